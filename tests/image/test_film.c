/* Films: GIF's compression against a decoder, palettes, complete frames, and refusals. */
#include "test.h"

#include <unistd.h>

#include "cvol/film.h"
#include "image/palette.h"
#include "random.h"

static cvol_context *context;
static char folder[] = "/tmp/cvol-film-XXXXXX";
static char path[64];

static int setup(void **state)
{
    (void)state;
    strcpy(folder + strlen(folder) - 6, "XXXXXX");
    context = cvol_context_create();
    return context && mkdtemp(folder) ? 0 : -1;
}

static int teardown(void **state)
{
    (void)state;
    unlink(path);
    if (rmdir(folder)) /* only the film may remain */
        return -1;
    cvol_context_free(context);
    return 0;
}

static const char *name(const char *film)
{
    snprintf(path, sizeof path, "%s/%s", folder, film);
    return path;
}

/* ---- a decoder of GIF's compression --------------------------------------------------------- */

typedef struct reader {
    const uint8_t *at, *end;
    size_t left; /* of the block */
    uint32_t bits;
    int count;
} reader;

static int next_byte(reader *r)
{
    if (!r->left && r->at < r->end)
        r->left = *r->at++;
    if (!r->left || r->at == r->end)
        return -1;
    r->left--;
    return *r->at++;
}

static int next_code(reader *r, int width)
{
    while (r->count < width) {
        const int byte = next_byte(r);
        if (byte < 0)
            return -1;
        r->bits |= (uint32_t)byte << r->count;
        r->count += 8;
    }
    const int code = (int)(r->bits & ((1u << width) - 1));
    r->bits >>= width;
    r->count -= width;
    return code;
}

/* Indices into `out`; returns their number, or -1. *after: the bytes behind the image's data. */
static long decode(uint8_t *out, long most, const uint8_t *data, size_t size, const uint8_t **after)
{
    reader r = {data + 1, data + size, 0, 0, 0};
    static uint8_t strings[4096][4096];
    static int lengths[4096];
    int next = 258, width = 9, before = -1;
    long count = 0;
    if (size < 2 || data[0] != 8)
        return -1;
    for (;;) {
        const int code = next_code(&r, width);
        if (code == 256) {
            next = 258;
            width = 9;
            before = -1;
            continue;
        }
        if (code == 257)
            break;
        if (code < 0 || code > next || (code == next && before < 0))
            return -1;
        uint8_t text[4096];
        int length = 1;
        text[0] = (uint8_t)code;
        if (code >= 258 && code < next) {
            length = lengths[code];
            memcpy(text, strings[code], (size_t)length);
        } else if (code == next) {
            length = before < 256 ? 1 : lengths[before];
            if (before < 256)
                text[0] = (uint8_t)before;
            else
                memcpy(text, strings[before], (size_t)length);
            text[length] = text[0];
            length++;
        }
        if (count + length > most)
            return -1;
        memcpy(out + count, text, (size_t)length);
        count += length;
        if (before >= 0 && next < 4096) {
            int begin = before < 256 ? 1 : lengths[before];
            if (before < 256)
                strings[next][0] = (uint8_t)before;
            else
                memcpy(strings[next], strings[before], (size_t)begin);
            strings[next][begin] = text[0];
            lengths[next++] = begin + 1;
        }
        if (next >= 1 << width && width < 12)
            width++;
        before = code;
    }
    if (after)
        *after = r.at + r.left + 1;
    return r.at + r.left < data + size && r.at[r.left] == 0 ? count : -1;
}

/* ---- palettes ----------------------------------------------------------------------------- */

/* All colours exactly if the palette has room; otherwise close ones. */
static void test_palette(void **state)
{
    (void)state;
    uint8_t rgba[4 * 4096], indices[4096];
    for (int colours = 1; colours <= 4096; colours *= 8) {
        cvol_palette *palette = cvol_palette_create();
        for (int i = 0; i < 4096; i++) {
            const int k = i % colours;
            rgba[4 * i] = (uint8_t)(16 * (k % 16));
            rgba[4 * i + 1] = (uint8_t)(16 * (k / 16 % 16));
            rgba[4 * i + 2] = (uint8_t)(16 * (k / 256));
            rgba[4 * i + 3] = 255;
        }
        cvol_palette_count(palette, rgba, 4096);
        assert_true(cvol_palette_choose(palette));
        assert_int_equal(cvol_palette_size(palette), colours < 255 ? colours : 255);
        cvol_palette_map(palette, indices, rgba, 4096, 3);
        double squares = 0;
        for (int i = 0; i < 4096; i++)
            for (int c = 0; c < 3; c++) {
                const int off = cvol_palette_colour(palette, indices[i])[c] - rgba[4 * i + c];
                squares += off * off;
                assert_true(colours >= 255 || off == 0);
            }
        assert_true(sqrt(squares / 3 / 4096) < 32);
        cvol_palette_free(palette);
    }
}

/* ---- films -------------------------------------------------------------------------------- */

#define WIDTH 37
#define HEIGHT 23
#define FRAMES 7

static cvol_image *frame(int number)
{
    cvol_image *image;
    assert_int_equal(cvol_image_create(context, &image, WIDTH, HEIGHT), CVOL_OK);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            uint8_t *p = image->rgba + 4 * (x + WIDTH * y);
            const int inside = abs(x - 5 - 3 * number) < 4 && abs(y - 11) < 5;
            p[0] = (uint8_t)(inside ? 240 : 16);
            p[1] = (uint8_t)(inside ? 40 * (y % 4) : 16);
            p[2] = 32;
            p[3] = 255;
        }
    return image;
}

static uint8_t *read_film(size_t *size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    uint8_t *data = malloc(1 << 20);
    *size = fread(data, 1, 1 << 20, file);
    fclose(file);
    return data;
}

static void make_film(double rate)
{
    cvol_film_options options = cvol_film_options_defaults();
    cvol_film *film;
    options.frames_per_second = rate;
    options.quality = 100;
    assert_int_equal(cvol_film_open(context, &film, path, WIDTH, HEIGHT, &options), CVOL_OK);
    for (int i = 0; i < FRAMES && cvol_film_needs_palette(film); i++) {
        cvol_image *image = frame(i);
        assert_int_equal(cvol_film_sample_palette(context, film, image), CVOL_OK);
        cvol_image_free(image);
    }
    for (int i = 0; i < FRAMES; i++) {
        cvol_image *image = frame(i);
        assert_int_equal(cvol_film_add(context, film, image), CVOL_OK);
        cvol_image_free(image);
        assert_int_not_equal(access(path, F_OK), 0); /* the file has no name yet */
    }
    assert_int_equal(cvol_film_commit(context, film), CVOL_OK);
}

static unsigned u16(const uint8_t *at)
{
    return at[0] | (unsigned)at[1] << 8;
}

/* Every frame, drawn over those before, is its picture. */
static void test_gif(void **state)
{
    (void)state;
    const double rate = 30;
    name("a.gif");
    make_film(rate);
    size_t size;
    uint8_t *data = read_film(&size), *shown = calloc(3, WIDTH * HEIGHT), indices[WIDTH * HEIGHT];
    assert_memory_equal(data, "GIF89a", 6);
    assert_int_equal(u16(data + 6), WIDTH);
    assert_int_equal(u16(data + 8), HEIGHT);
    const uint8_t *palette = data + 13, *at = palette + 768 + 19;
    unsigned delays = 0;
    for (int i = 0; i < FRAMES; i++) {
        assert_int_equal(at[0], 0x21);
        assert_int_equal(at[1], 0xf9);
        delays += u16(at + 4);
        at += 8;
        assert_int_equal(at[0], 0x2c);
        const unsigned x0 = u16(at + 1), y0 = u16(at + 3), w = u16(at + 5), h = u16(at + 7);
        assert_true(w >= 1 && h >= 1 && x0 + w <= WIDTH && y0 + h <= HEIGHT);
        assert_true(i == 0 ? w == WIDTH && h == HEIGHT : w * h < WIDTH * HEIGHT / 2);
        const long count = decode(indices, WIDTH * HEIGHT, at + 10, (size_t)(data + size - at) - 10,
                                  &at);
        assert_int_equal(count, w * h);
        for (unsigned k = 0; k < w * h; k++)
            if (indices[k] != 255)
                memcpy(shown + 3 * (x0 + k % w + WIDTH * (y0 + k / w)), palette + 3 * indices[k],
                       3);
        cvol_image *wanted = frame(i);
        for (int k = 0; k < WIDTH * HEIGHT; k++)
            assert_memory_equal(shown + 3 * k, wanted->rgba + 4 * k, 3);
        cvol_image_free(wanted);
    }
    assert_int_equal(*at, 0x3b);
    assert_ptr_equal(at + 1, data + size);
    assert_int_equal(delays, (unsigned)round(FRAMES * 100 / rate));
    free(data);
    free(shown);
}

static void test_webp(void **state)
{
    (void)state;
    if (!strstr(cvol_film_formats(), ".webp"))
        skip();
    name("a.webp");
    make_film(12.5);
    size_t size;
    uint8_t *data = read_film(&size);
    int frames = 0;
    unsigned duration = 0;
    assert_memory_equal(data, "RIFF", 4);
    assert_memory_equal(data + 8, "WEBPVP8X", 8);
    for (size_t i = 12; i + 24 <= size;) {
        const unsigned bytes = u16(data + i + 4) | u16(data + i + 6) << 16;
        if (!memcmp(data + i, "ANMF", 4)) {
            frames++;
            duration += u16(data + i + 20) | (unsigned)data[i + 22] << 16;
        }
        i += 8 + bytes + bytes % 2;
    }
    assert_int_equal(frames, FRAMES);
    assert_int_equal(duration, FRAMES * 80);
    free(data);
}

static void refuse(int code, const char *film_name, int width, double rate, int quality)
{
    const cvol_film_options options = {sizeof(cvol_film_options), rate, quality};
    cvol_film *film;
    assert_int_equal(cvol_film_open(context, &film, name(film_name), width, 5, &options), code);
    assert_null(film);
}

static void test_refusals(void **state)
{
    (void)state;
    refuse(CVOL_ERROR_ARGUMENT, "a.png", 5, 25, 90);
    refuse(CVOL_ERROR_ARGUMENT, "a.gif", 0, 25, 90);
    refuse(CVOL_ERROR_ARGUMENT, "a.gif", 32769, 25, 90);
    refuse(CVOL_ERROR_ARGUMENT, "a.gif", 5, 0, 90);
    refuse(CVOL_ERROR_ARGUMENT, "a.gif", 5, NAN, 90);
    refuse(CVOL_ERROR_ARGUMENT, "a.gif", 5, 51, 90);
    refuse(CVOL_ERROR_ARGUMENT, "a.gif", 5, 25, 101);
    refuse(CVOL_ERROR_IO, "none/a.gif", 5, 25, 90);
    if (!strstr(cvol_film_formats(), ".webp"))
        refuse(CVOL_ERROR_UNSUPPORTED, "a.webp", 5, 25, 90);
    const cvol_film_options options = cvol_film_options_defaults();
    cvol_film *film;
    cvol_image *image, *other;
    assert_int_equal(cvol_film_open(context, &film, name("a.gif"), 5, 5, &options), CVOL_OK);
    assert_int_equal(cvol_film_commit(context, film), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_film_open(context, &film, path, 5, 5, &options), CVOL_OK);
    assert_int_equal(cvol_image_create(context, &image, 5, 5), CVOL_OK);
    assert_int_equal(cvol_image_create(context, &other, 5, 6), CVOL_OK);
    assert_int_equal(cvol_film_add(context, film, other), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_film_add(context, film, image), CVOL_ERROR_ARGUMENT); /* transparent */
    cvol_film_abandon(film);
    cvol_film_abandon(NULL);
    assert_int_not_equal(access(path, F_OK), 0);
    cvol_image_free(image);
    cvol_image_free(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_palette, setup, teardown),
        cmocka_unit_test_setup_teardown(test_gif, setup, teardown),
        cmocka_unit_test_setup_teardown(test_webp, setup, teardown),
        cmocka_unit_test_setup_teardown(test_refusals, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
