/* Spectra that keep only the strongest places, and their use for a slice.
 *
 * Places are counted by magnitude. Those above the threshold for the requested number are kept, in
 * bricks of 8 x 8 x 8: a bit for each place, and the values of the kept places. (Low frequencies
 * are the strongest, so a low box is included by itself.) A slice passes through few bricks. They
 * are unpacked into pages, each with the first columns of its neighbour along x, so that the places
 * of a row always lie in one page. Empty bricks are page 0. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "render/fourier/spectrum.h"

#define SIDE CVOL_FOURIER_BRICK
#define PAGE ((size_t)2 * CVOL_FOURIER_PAGE_ROW * SIDE * SIDE)
#define BINS ((size_t)1 << 16)

/* ---- keeping --------------------------------------------------------------------------------- */

/* |re|^2 + |im|^2 in arbitrary, increasing units: the first bits of a float. */
static size_t bin_of(const uint16_t *place)
{
    float sum = 0;
    for (int k = 0; k < 2; k++) {
        const uint32_t bits = (uint32_t)(place[k] & 0x7fff) << 13;
        float value;
        memcpy(&value, &bits, sizeof value);
        value *= 0x1p112f;
        sum += value * value;
    }
    uint32_t bits;
    memcpy(&bits, &sum, sizeof bits);
    return bits >> 15;
}

/* The mean energy of a bin: its middle. */
static double energy_of(size_t bin)
{
    const uint32_t bits = (uint32_t)bin << 15 | 1 << 14;
    float sum;
    memcpy(&sum, &bits, sizeof sum);
    return bin && isfinite(sum) ? (double)sum : 0;
}

/* Places of row (v, w): 0 <= u <= N_x / 2, in stored form. */
static const uint16_t *row_of(const cvol_fourier_spectrum *of, size_t v, size_t w)
{
    return of->values + 2 * (of->stride_v * (v + CVOL_FOURIER_BEFORE) +
                             of->stride_w * (w + CVOL_FOURIER_BEFORE));
}

/* The lowest bin that is kept, so that at most `most` places are; bin 0 (value 0) never is. */
static int find_threshold(cvol_context *context, size_t *threshold, double *lost,
                          const cvol_fourier_spectrum *of, double most)
{
    const int threads = cvol_context_threads(context);
    const size_t counts = (size_t)threads * BINS;
    uint64_t *bins = cvol_allocate_zero(counts, sizeof *bins);
    if (!bins)
        return cvol_fail_memory(context, counts * sizeof *bins, "a histogram of frequencies");
#pragma omp parallel for num_threads(threads) schedule(static)
    for (size_t w = 0; w < of->dims[2]; w++) {
        uint64_t *own = bins + (size_t)cvol_thread_index() * BINS;
        for (size_t v = 0; v < of->dims[1]; v++) {
            const uint16_t *row = row_of(of, v, w) + 2 * CVOL_FOURIER_BEFORE;
            for (size_t u = 0; u <= of->dims[0] / 2; u++)
                own[bin_of(row + 2 * u)]++;
        }
    }
    double places = 0, kept = 0, dropped = 0;
    *threshold = BINS;
    for (size_t bin = BINS - 1; bin > 0; bin--) {
        double count = 0;
        for (int t = 0; t < threads; t++)
            count += (double)bins[(size_t)t * BINS + bin];
        places += count;
        if (places <= most) {
            *threshold = bin;
            kept += count * energy_of(bin);
        } else {
            dropped += count * energy_of(bin);
        }
    }
    free(bins);
    *lost = dropped > 0 ? sqrt(dropped / (kept + dropped)) : 0;
    return CVOL_OK;
}

/* Finds the places of a brick that are kept: a word for each w, a bit for each v and u. Returns
 * their number. */
static size_t find_kept(uint64_t words[SIDE], const cvol_fourier_spectrum *of, const size_t at[3],
                        size_t threshold)
{
    size_t count = 0;
    for (size_t k = 0; k < SIDE; k++) {
        const size_t w = SIDE * at[2] + k;
        words[k] = 0;
        for (size_t j = 0; j < SIDE && w < of->dims[2]; j++) {
            const size_t v = SIDE * at[1] + j;
            for (size_t i = 0; i < SIDE && v < of->dims[1]; i++) {
                const size_t u = SIDE * at[0] + i;
                if (u < of->stride_v && bin_of(row_of(of, v, w) + 2 * u) >= threshold)
                    words[k] |= (uint64_t)1 << (SIDE * j + i);
            }
        }
        count += (size_t)__builtin_popcountll(words[k]);
    }
    return count;
}

static void place_of(size_t at[3], const cvol_fourier_bricks *bricks, size_t brick)
{
    at[0] = brick % bricks->count[0];
    at[1] = brick / bricks->count[0] % bricks->count[1];
    at[2] = brick / bricks->count[0] / bricks->count[1];
}

static void pack(cvol_fourier_bricks *bricks, const cvol_fourier_spectrum *of, size_t brick)
{
    size_t at[3];
    place_of(at, bricks, brick);
    uint16_t *out = bricks->values + 2 * bricks->first[brick];
    for (size_t k = 0; k < SIDE; k++)
        for (uint64_t left = bricks->words[SIDE * brick + k]; left; left &= left - 1) {
            const size_t bit = (size_t)__builtin_ctzll(left);
            const uint16_t *from = row_of(of, SIDE * at[1] + bit / SIDE, SIDE * at[2] + k) +
                                   2 * (SIDE * at[0] + bit % SIDE);
            *out++ = from[0];
            *out++ = from[1];
        }
}

static int make_bricks(cvol_context *context, cvol_fourier_bricks *bricks,
                       const cvol_fourier_spectrum *of, size_t threshold)
{
    bricks->count[0] = (of->stride_v + SIDE - 1) / SIDE;
    for (int a = 1; a < 3; a++)
        bricks->count[a] = (of->dims[a] + SIDE - 1) / SIDE;
    const size_t all = bricks->count[0] * bricks->count[1] * bricks->count[2];
    bricks->all = all;
    bricks->first = cvol_allocate(all + 1, sizeof *bricks->first);
    bricks->words = cvol_allocate(all, SIDE * sizeof *bricks->words);
    if (!bricks->first || !bricks->words)
        return cvol_fail_memory(context, all * (SIDE + 1) * 8, "bricks of frequencies");
#pragma omp parallel for num_threads(cvol_context_threads(context)) schedule(static)
    for (size_t brick = 0; brick < all; brick++) {
        size_t at[3];
        place_of(at, bricks, brick);
        bricks->first[brick] = find_kept(bricks->words + SIDE * brick, of, at, threshold);
    }
    size_t total = 0;
    for (size_t brick = 0; brick < all; brick++) {
        const size_t count = bricks->first[brick];
        bricks->first[brick] = total;
        total += count;
    }
    bricks->first[all] = total;
    bricks->values = cvol_allocate(total + 1, 2 * sizeof *bricks->values);
    if (!bricks->values)
        return cvol_fail_memory(context, 4 * total, "frequencies");
#pragma omp parallel for num_threads(cvol_context_threads(context)) schedule(static)
    for (size_t brick = 0; brick < all; brick++)
        pack(bricks, of, brick);
    return CVOL_OK;
}

int cvol_fourier_keep_strongest(cvol_context *context, cvol_fourier_spectrum *of, double most)
{
    size_t threshold = 0;
    double lost = 0;
    int code = find_threshold(context, &threshold, &lost, of, most);
    if (!code)
        code = make_bricks(context, &of->bricks, of, threshold);
    if (code) {
        cvol_fourier_bricks_free(&of->bricks);
        return code;
    }
    of->bricks.lost = lost;
    free(of->values);
    of->values = NULL;
    return CVOL_OK;
}

void cvol_fourier_bricks_free(cvol_fourier_bricks *bricks)
{
    free(bricks->first);
    free(bricks->words);
    free(bricks->values);
    *bricks = (cvol_fourier_bricks){0};
}

/* ---- pages ----------------------------------------------------------------------------------- */

/* Unpacks the places of a brick with these bits for each v, `shift` columns on. */
static void unpack(uint16_t *page, const cvol_fourier_bricks *bricks, size_t brick, uint64_t bits,
                   size_t shift)
{
    const uint16_t *from = bricks->values + 2 * bricks->first[brick];
    for (size_t k = 0; k < SIDE; k++)
        for (uint64_t left = bricks->words[SIDE * brick + k]; left; left &= left - 1, from += 2) {
            const size_t bit = (size_t)__builtin_ctzll(left);
            if (!(bits >> bit & 1))
                continue;
            const size_t row = SIDE * k + bit / SIDE, column = bit % SIDE + shift;
            memcpy(page + 2 * (CVOL_FOURIER_PAGE_ROW * row + column), from, 2 * sizeof *from);
        }
}

static int is_empty(const cvol_fourier_bricks *bricks, size_t brick)
{
    return bricks->first[brick] == bricks->first[brick + 1];
}

/* Returns 1 if the plane through 0 across `normal` (by g) comes near a brick's places, within the
 * reach of interpolation. Places beyond half of an axis are negative frequencies. */
static int is_touched(const cvol_fourier_spectrum *of, const size_t at[3], const double normal[3])
{
    double reach = 0, middle[3];
    for (int a = 0; a < 3; a++) {
        reach += fabs(normal[a]) * (SIDE / 2.0 + CVOL_FOURIER_TAPS - 1);
        middle[a] = (double)(SIDE * at[a]) + SIDE / 2.0;
    }
    for (int wrap = 0; wrap < 4; wrap++) {
        const double v = middle[1] - (wrap & 1 ? (double)of->dims[1] : 0);
        const double w = middle[2] - (wrap & 2 ? (double)of->dims[2] : 0);
        if (fabs(normal[0] * middle[0] + normal[1] * v + normal[2] * w) <= reach)
            return 1;
    }
    return 0;
}

static int make_room(cvol_context *context, cvol_fourier_pages *pages, size_t all, size_t count)
{
    if (!pages->table)
        pages->table = cvol_allocate(all, sizeof *pages->table);
    if (pages->table && pages->room < count) {
        free(pages->values);
        pages->values = cvol_allocate(count + count / 4, PAGE * sizeof *pages->values);
        pages->room = pages->values ? count + count / 4 : 0;
    }
    return pages->table && pages->values
               ? CVOL_OK
               : cvol_fail_memory(context, count * PAGE * sizeof *pages->values,
                                  "a slice's bricks");
}

int cvol_fourier_pages_load(cvol_context *context, cvol_fourier_pages *pages,
                            const cvol_fourier_spectrum *of, const double normal[3])
{
    const cvol_fourier_bricks *bricks = &of->bricks;
    const size_t all = bricks->all;
    int code = make_room(context, pages, all, pages->room ? pages->room : 1);
    if (code)
        return code;
    uint32_t count = 1;
    for (size_t brick = 0; brick < all; brick++) {
        size_t at[3];
        place_of(at, bricks, brick);
        const int next = at[0] + 1 < bricks->count[0] && !is_empty(bricks, brick + 1);
        pages->table[brick] = 0;
        if ((next || !is_empty(bricks, brick)) && is_touched(of, at, normal))
            pages->table[brick] = count++;
    }
    code = make_room(context, pages, all, count);
    if (code)
        return code;
    memset(pages->values, 0, PAGE * sizeof *pages->values);
#pragma omp parallel for num_threads(cvol_context_threads(context)) schedule(dynamic, 256)
    for (size_t brick = 0; brick < all; brick++) {
        if (!pages->table[brick])
            continue;
        uint16_t *page = pages->values + PAGE * pages->table[brick];
        memset(page, 0, PAGE * sizeof *page);
        unpack(page, bricks, brick, ~(uint64_t)0, 0);
        if ((brick + 1) % bricks->count[0])
            unpack(page, bricks, brick + 1, 0x1f1f1f1f1f1f1f1f, SIDE);
    }
    return CVOL_OK;
}

void cvol_fourier_pages_free(cvol_fourier_pages *pages)
{
    free(pages->table);
    free(pages->values);
    *pages = (cvol_fourier_pages){0};
}
