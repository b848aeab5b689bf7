/* One dimension: filters and gates a voice without decompressing it.
 *
 * The program synthesises a voice (a pulse train of varying pitch through three moving formants,
 * and noise for consonants), compresses it by a DHT of all 65,536 samples, limits it to a telephone
 * band by one product per term (convolve), and fades it in and out by a product with an envelope
 * (multiply). It writes speech.wav and speech_processed.wav. */
#include <stdint.h>
#include <string.h>

#include "example.h"

enum { COUNT = 65536, RATE = 16000, TAPS = 255 };
#define PI 3.14159265358979323846

/* ---- the voice ---------------------------------------------------------------------------- */

/* A resonance of the vocal tract: two poles at +-frequency. */
typedef struct resonance {
    double before, before_that;
} resonance;

static double resonate(resonance *r, double in, double frequency, double bandwidth)
{
    const double radius = exp(-PI * bandwidth / RATE);
    double out = in + 2 * radius * cos(2 * PI * frequency / RATE) * r->before -
                 radius * radius * r->before_that;
    r->before_that = r->before;
    r->before = out;
    return out;
}

static void synthesise(float *voice)
{
    static const double vowels[4][3] = {
        {730, 1090, 2440}, {270, 2290, 3010}, {300, 870, 2240}, {530, 1840, 2480}};
    resonance tract[3] = {{0, 0}, {0, 0}, {0, 0}};
    double phase = 0, largest = 0;
    uint32_t noise = 1;
    for (int i = 0; i < COUNT; i++) {
        const double t = (double)i / RATE, syllable = t * 3;
        const double *from = vowels[(int)syllable % 4], *to = vowels[((int)syllable + 1) % 4];
        const double part = syllable - floor(syllable);
        phase += (120 + 25 * sin(2 * PI * 0.7 * t)) / RATE;
        double pulse = 0;
        if (phase >= 1) {
            phase -= 1;
            pulse = 1;
        }
        noise = noise * 1664525u + 1013904223u;
        const double hiss = ((double)(noise >> 8) / (1 << 24) - 0.5) * (part < 0.12 ? 0.3 : 0.002);
        double sample = pulse * (part < 0.12 ? 0.1 : 1) + hiss;
        for (int f = 0; f < 3; f++)
            sample = resonate(&tract[f], sample, from[f] + (to[f] - from[f]) * part, 60 + 30 * f) *
                     0.2;
        voice[i] = (float)sample;
        largest = fmax(largest, fabs(sample));
    }
    for (int i = 0; i < COUNT; i++)
        voice[i] = (float)((double)voice[i] / largest * 0.8);
}

/* ---- the filter and the gate -------------------------------------------------------------- */

/* Windowed sinc, 300 to 3400 Hz, centred on sample 0 of a periodic signal. */
static void make_band(float *band)
{
    memset(band, 0, COUNT * sizeof *band);
    for (int m = -(TAPS / 2); m <= TAPS / 2; m++) {
        const double high = 2 * 3400.0 / RATE, low = 2 * 300.0 / RATE;
        double h = m ? (sin(PI * high * m) - sin(PI * low * m)) / (PI * m) : high - low;
        h *= 0.54 + 0.46 * cos(2 * PI * m / TAPS);
        band[m < 0 ? COUNT + m : m] = (float)h;
    }
}

/* Opens twice, with soft edges. */
static void make_gate(float *gate)
{
    for (int i = 0; i < COUNT; i++)
        gate[i] = (float)pow(sin(2 * PI * (double)i / COUNT), 2);
}

/* ---- the same on the samples --------------------------------------------------------------- */

static void filter_exactly(float *out, const float *voice, const float *band)
{
    for (int i = 0; i < COUNT; i++) {
        double sum = 0;
        for (int m = -(TAPS / 2); m <= TAPS / 2; m++)
            sum += (double)band[(m + COUNT) % COUNT] * (double)voice[(i - m + COUNT) % COUNT];
        out[i] = (float)sum;
    }
}

/* ---- sound ---------------------------------------------------------------------------------- */

static void put(uint8_t **at, uint32_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        *(*at)++ = (uint8_t)(value >> 8 * i);
}

static void write_wav(const char *path, const float *samples)
{
    uint8_t *data = need_memory(malloc(44 + 2 * COUNT)), *at = data;
    memcpy(at, "RIFF", 4);
    at += 4;
    put(&at, 36 + 2 * COUNT, 4);
    memcpy(at, "WAVEfmt ", 8);
    at += 8;
    put(&at, 16, 4);
    put(&at, 1, 2); /* PCM */
    put(&at, 1, 2); /* channels */
    put(&at, RATE, 4);
    put(&at, 2 * RATE, 4);
    put(&at, 2, 2);
    put(&at, 16, 2);
    memcpy(at, "data", 4);
    at += 4;
    put(&at, 2 * COUNT, 4);
    for (int i = 0; i < COUNT; i++) {
        double value = fmin(fmax((double)samples[i], -1), 1) * 32767;
        put(&at, (uint32_t)(int32_t)lrint(value), 2);
    }
    FILE *file = fopen(path, "wb");
    int written = file && fwrite(data, 1, 44 + 2 * COUNT, file) == 44 + 2 * COUNT;
    if (!file || fclose(file) || !written) {
        fprintf(stderr, "cannot write %s\n", path);
        exit(1);
    }
    free(data);
    printf("wrote %s\n", path);
}

int main(void)
{
    float *voice = need_memory(malloc(COUNT * sizeof *voice));
    float *band = need_memory(malloc(COUNT * sizeof *band));
    float *gate = need_memory(malloc(COUNT * sizeof *gate));
    float *exact = need_memory(malloc(COUNT * sizeof *exact));
    synthesise(voice);
    make_band(band);
    make_gate(gate);

    cvol_context *context = need_memory(cvol_context_create());
    const cvol_grid grid = cvol_grid_make(COUNT, 1, 1, CVOL_FLOAT32);
    cvol_array *a, *h, *g, *filtered, *processed;
    const cvol_keep tenth = cvol_keep_rho(0.1), all = cvol_keep_all(), few = cvol_keep_terms(8, 0);
    must(context, cvol_array_compress(context, &a, voice, &grid, 1, CVOL_DHT, 0, &tenth));
    must(context, cvol_array_compress(context, &h, band, &grid, 1, CVOL_DHT, 0, &all));
    must(context, cvol_array_compress(context, &g, gate, &grid, 1, CVOL_DHT, 0, &few));
    report(context, "voice", a, voice);

    must(context, cvol_array_convolve(context, &filtered, a, h, NULL));
    filter_exactly(exact, voice, band);
    report(context, "band-pass (convolve)", filtered, exact);

    cvol_multiply_report plan;
    must(context,
         cvol_array_multiply(context, &processed, filtered, g, NULL, CVOL_PLAN_AUTO, &plan));
    for (int i = 0; i < COUNT; i++)
        exact[i] *= gate[i];
    report(context, "gate (multiply)", processed, exact);
    printf("multiply's plan: %s: %s\n", cvol_plan_name(plan.plan), plan.reason);

    const size_t begin[3] = {0, 0, 0}, end[3] = {COUNT, 1, 1};
    must(context, cvol_array_evaluate_real(context, exact, processed, begin, end));
    write_wav("speech.wav", voice);
    write_wav("speech_processed.wav", exact);

    cvol_array_free(a);
    cvol_array_free(h);
    cvol_array_free(g);
    cvol_array_free(filtered);
    cvol_array_free(processed);
    cvol_context_free(context);
    free(voice);
    free(band);
    free(gate);
    free(exact);
    return 0;
}
