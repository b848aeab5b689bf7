/* Levels: a block's low frequencies on the few points that these need (a scaled inverse transform:
 * Dugad and Ahuja, "A fast scheme for image size change in the compressed domain", 2001). */
#include "render/sheet/frame/level.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "transform/cell.h"
#include "transform/cell_points.h"
#include "transform/lap.h"

/* Samples of a level that is stored. */
#define MAX_SAMPLES ((size_t)1 << 27)
#define SIDE CVOL_LEVEL_BLOCK

/* The working data for a level. Blocks become `points` samples per axis. They are evaluated on this
 * number of points, but on at least 2; split blocks on at least 4, so that a sub-block of 4 samples
 * has a point. */
typedef struct maker {
    const cvol_array *array;
    cvol_sheet_level *level;
    int pitch, points, whole_points, split_points;
    int whole_keep, split_keep; /* terms below this place along each axis count */
    int means;                  /* samples are means of the level below, and have no prefilter */
    size_t first_cells;         /* layers of blocks of the mask before the array's first slice */
    size_t size[3];             /* the level's samples */
    float *bases;
    cvol_block_axes whole, split;
} maker;

/* ---- positions of samples -------------------------------------------------------------------- */

size_t cvol_sheet_level_size(size_t samples, int level)
{
    const size_t pitch = (size_t)1 << level;
    return (samples + pitch - 1) / pitch;
}

int cvol_sheet_level_fits(const cvol_array *array, int level)
{
    size_t samples = 1;
    for (int a = 0; a < 3; a++) {
        const size_t size = (array->grid.dims[a] >> level) + SIDE;
        if (size > MAX_SAMPLES / samples)
            return 0;
        samples *= size;
    }
    return 1;
}

static size_t index_of(const cvol_sheet_level *level, size_t x, size_t y, size_t z)
{
    const size_t *blocks = level->shape->blocks;
    const size_t block = x / SIDE + blocks[0] * (y / SIDE + blocks[1] * (z / SIDE));
    return block * CVOL_LEVEL_BLOCK_SAMPLES + x % SIDE + SIDE * (y % SIDE + SIDE * (z % SIDE));
}

/* ---- evaluating ------------------------------------------------------------------------------ */

/* Bases at all samples become their means over each of `points` cells. */
static void average_basis(float *basis, int B, int points, int width)
{
    for (int u = 0; u < B; u++) {
        const int pitch = B / points;
        float fine[CVOL_BLOCK_MAX];
        memcpy(fine, basis + u * width, sizeof *fine * (size_t)B);
        memset(basis + u * width, 0, sizeof *basis * (size_t)width);
        for (int i = 0; i < B; i++)
            basis[u * width + i / pitch] += fine[i] / (float)pitch;
    }
}

/* Lines of B are read as lines of `points`: rows move together. */
static void narrow_basis(float *basis, int B, int points)
{
    for (int u = 0; u < B; u++)
        memmove(basis + u * points, basis + u * B, sizeof *basis * (size_t)points);
}

/* The same bases as make_axes, for means over the cells of `points`. */
static void make_means(float *bases, int B, int points)
{
    const int square = CVOL_BLOCK_MAX * CVOL_BLOCK_MAX, lanes = B < 16 ? 16 : B;
    for (int k = 0; k < (B == CVOL_CELL ? 3 : 1); k++) {
        float *parts = bases + 2 * k * square;
        for (int j = 0; j < 2; j++) {
            const int width = j ? B : lanes;
            if (k)
                cvol_cell_points_basis(parts + j * square, k == 2 ? 4 : 8, B, width);
            else
                cvol_sheet_basis(parts + j * square, B, B, width);
            average_basis(parts + j * square, B, points, width);
        }
        narrow_basis(parts + square, B, points);
    }
}

/* Bases at `points` of a block's places, whole or in sub-blocks. */
static cvol_block_axes make_axes(float *bases, int B, int points)
{
    const int square = CVOL_BLOCK_MAX * CVOL_BLOCK_MAX;
    cvol_block_axes axes = {.lane = 0,
                            .row = 1,
                            .sheet = 2,
                            .lane_points = points,
                            .row_points = points,
                            .sheet_points = points,
                            .lane_basis = bases,
                            .row_basis = bases + square,
                            .sheet_basis = bases + square};
    cvol_sheet_basis(bases, B, points, B < 16 ? 16 : B);
    cvol_sheet_basis(bases + square, B, points, points);
    for (int i = 0; i < 2 && B == CVOL_CELL; i++) {
        float *parts = bases + (2 + 2 * i) * square;
        cvol_cell_points_basis(parts, i ? 4 : 8, points, B);
        cvol_cell_points_basis(parts + square, i ? 4 : 8, points, points);
        axes.lane_parts[i] = parts;
        axes.row_parts[i] = axes.sheet_parts[i] = parts + square;
    }
    return axes;
}

/* Keeps the terms below place `keep` along each axis; others would alias. */
static void keep_low(cvol_block *out, uint32_t *words, const cvol_block *block, int block_log2,
                     uint32_t keep)
{
    const uint32_t mask = (UINT32_C(1) << block_log2) - 1;
    const uint32_t *from = block->terms, *end = cvol_block_end(block);
    *out = *block;
    if (block->low[0] <= keep && block->low[1] <= keep && block->low[2] <= keep)
        return;
    out->terms = words;
    out->words = 0;
    while (from < end) {
        uint32_t place;
        const int32_t value = cvol_term_unpack(&from, &place, cvol_place_bits(block_log2));
        if (place >> 2 * block_log2 >= keep)
            break; /* places rise */
        if ((place & mask) < keep && (place >> block_log2 & mask) < keep)
            out->words += cvol_term_pack(words + out->words, place, value,
                                         cvol_place_bits(block_log2));
    }
    cvol_block_find_low(out, block_log2);
}

typedef struct thread_work {
    uint32_t words[2 * CVOL_LEVEL_BLOCK_SAMPLES];
    float fine[CVOL_LEVEL_BLOCK_SAMPLES];
    cvol_block_work block;
} thread_work;

/* Means of n^3 neighbours, from `points` n along each axis, rows of 16. */
static void average(float *out, const float *fine, int points, int n)
{
    const float share = 1.0f / (float)(n * n * n);
    for (int z = 0; z < points; z++)
        for (int y = 0; y < points; y++)
            for (int x = 0; x < points; x++) {
                float sum = 0;
                for (int k = 0; k < n * n * n; k++)
                    sum += fine[x * n + k % n +
                                SIDE * (y * n + k / n % n + SIDE * (z * n + k / n / n))];
                out[x + SIDE * (y + SIDE * z)] = share * sum;
            }
}

static void evaluate_block(const maker *m, thread_work *work, size_t index)
{
    const cvol_array *array = m->array;
    const size_t points = (size_t)m->points, i = index % array->blocks[0],
                 j = index / array->blocks[0] % array->blocks[1],
                 l = index / array->blocks[0] / array->blocks[1];
    const cvol_block *block = &array->block_table[index];
    const int evaluated = block->split ? m->split_points : m->whole_points;
    float *out = m->level->samples + index_of(m->level, i * points, j * points, l * points);
    cvol_block low = *block;
    keep_low(&low, work->words, block, array->block_log2,
             (uint32_t)(block->split ? m->split_keep : m->whole_keep));
    CVOL_SIMD_CHOOSE(cvol_sheet_evaluate)
    (evaluated == m->points ? out : work->fine, SIDE, SIDE * SIDE, &low,
     block->split ? &m->split : &m->whole, array->block_log2, (float)array->step, &work->block);
    if (evaluated > m->points)
        average(out, work->fine, m->points, evaluated / m->points);
}

static int evaluate(cvol_context *context, const maker *m)
{
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context))
    {
        thread_work *work = cvol_allocate(1, sizeof *work);
        if (!work) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic, 64)
        for (size_t i = 0; i < m->array->block_count; i++)
            if (work)
                evaluate_block(m, work, i);
        free(work);
    }
    return failed ? cvol_fail_memory(context, sizeof(thread_work), "a block") : CVOL_OK;
}

/* ---- lapped volumes -------------------------------------------------------------------------- */

/* The amount that the post-filter (transform/lap.h) adds to the mean of the `pitch` samples before
 * a face, and subtracts behind it: near w0 + far w1, from the differences of the nearest and of the
 * next samples of the level on both sides. Differences of mirrored samples between and before these
 * are linear. */
static void find_filter(float *near, float *far, double pitch)
{
    static const float H[4] = CVOL_LAP_POST_H;
    double sum[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        const double at = (k + 0.5) / pitch - 0.5, weight = (double)(H[k] + H[2 + k]) / pitch;
        sum[0] += weight * (1 - at);
        sum[1] += weight * at;
    }
    *near = (float)sum[0];
    *far = (float)sum[1];
}

/* Filters the faces across one axis, for the line of blocks of samples at (u, v) of the two other
 * axes. */
static void filter_line(const maker *m, int axis, size_t u, size_t v, float near, float far)
{
    const size_t n = m->array->grid.dims[axis], points = (size_t)m->points;
    const int other = axis == 0 ? 1 : 0;
    const size_t run = axis == 0 ? 1 : SIDE; /* consecutive samples */
    size_t at[3];
    at[other] = u;
    at[3 - axis - other] = v;
    for (size_t cell = 1; CVOL_CELL * cell + 2 <= n; cell++) {
        float *a[4];
        for (size_t i = 0; i < 4; i++) {
            at[axis] = points * cell + i - 2;
            a[i] = m->level->samples + index_of(m->level, at[0], at[1], at[2]);
        }
        for (size_t i = 0; i < run; i++) {
            const float c = near * (a[1][i] - a[2][i]) + far * (a[0][i] - a[3][i]);
            a[1][i] += c;
            a[2][i] -= c;
        }
    }
}

static void filter(cvol_context *context, const maker *m)
{
    float near, far;
    find_filter(&near, &far, m->pitch);
    for (int axis = 0; axis < 3; axis++) {
        const int first = axis == 0 ? 1 : 0, second = 3 - axis - first;
        const size_t step = axis == 0 ? 1 : SIDE;
#pragma omp parallel for num_threads(cvol_context_threads(context))
        for (size_t v = 0; v < m->size[second]; v++)
            for (size_t u = 0; u < m->size[first]; u += step)
                filter_line(m, axis, u, v, near, far);
    }
}

/* ---- background and mask --------------------------------------------------------------------- */

/* A block of the mask: its masked samples, rows y + 16 z, and the size along each axis that is
 * within the volume. */
typedef struct mask_cell {
    size_t size[3];
    uint16_t rows[CVOL_MASK_ROWS];
} mask_cell;

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* The share of the level's sample (x, y, z) of a block that is not masked. */
static float find_cover(const mask_cell *cell, size_t pitch, size_t x, size_t y, size_t z)
{
    const size_t begin[3] = {x * pitch, y * pitch, z * pitch};
    size_t size[3], masked = 0;
    for (int a = 0; a < 3; a++) {
        if (begin[a] >= cell->size[a])
            return 1;
        size[a] = least(pitch, cell->size[a] - begin[a]);
    }
    const unsigned which = ((1u << size[0]) - 1) << begin[0];
    for (size_t k = begin[2]; k < begin[2] + size[2]; k++)
        for (size_t j = begin[1]; j < begin[1] + size[1]; j++)
            masked += (size_t)__builtin_popcount(cell->rows[j + CVOL_MASK_CELL * k] & which);
    return 1 - (float)masked / (float)(size[0] * size[1] * size[2]);
}

/* Mixes the background into the samples of a block of the mask, or writes their cover. */
static void cover_cell(const maker *m, const size_t place[3], float background)
{
    const size_t pitch = (size_t)m->pitch, points = CVOL_MASK_CELL / pitch;
    const size_t in_mask[3] = {place[0], place[1], place[2] + m->first_cells};
    const cvol_mask_state state = cvol_mask_cell(m->array->mask, in_mask);
    mask_cell cell;
    if (state == CVOL_MASK_NONE && !m->level->cover)
        return;
    for (int a = 0; a < 3; a++)
        cell.size[a] = least(CVOL_MASK_CELL, m->array->grid.dims[a] - place[a] * CVOL_MASK_CELL);
    if (state == CVOL_MASK_SOME)
        cvol_sheet_mask_rows(cell.rows, m->array->mask, in_mask);
    for (size_t z = 0; z < points; z++)
        for (size_t y = 0; y < points; y++)
            for (size_t x = 0; x < points; x++) {
                const size_t at = index_of(m->level, place[0] * points + x, place[1] * points + y,
                                           place[2] * points + z);
                const float cover = state == CVOL_MASK_SOME ? find_cover(&cell, pitch, x, y, z)
                                                            : (float)(state == CVOL_MASK_NONE);
                float *sample = m->level->samples + at;
                if (m->level->cover)
                    m->level->cover[at] = cover;
                else
                    *sample = background + cover * (*sample - background);
            }
}

static void cover(cvol_context *context, const maker *m)
{
    const cvol_array *array = m->array;
    const float background = cvol_sheet_background(array, array->mask);
    size_t cells[3];
    for (int a = 0; a < 3; a++)
        cells[a] = (array->grid.dims[a] + CVOL_MASK_CELL - 1) / CVOL_MASK_CELL;
#pragma omp parallel for num_threads(cvol_context_threads(context)) schedule(dynamic, 16)
    for (size_t i = 0; i < cells[0] * cells[1] * cells[2]; i++) {
        const size_t cell[3] = {i % cells[0], i / cells[0] % cells[1], i / cells[0] / cells[1]};
        cover_cell(m, cell, background);
    }
}

/* ---- prefilter for linear interpolation ------------------------------------------------------ */

/* Linear interpolation between samples attenuates them. This prefilter compensates: c - (c' - 2 c +
 * c'') / 12 along each axis, the quasi-interpolant of least mean error (Condat, Blu and Unser,
 * "Beyond interpolation: optimal reconstruction by quasi-interpolation", 2005). */
#define SHARPER (1.0f / 12)

/* Along one axis: `run` adjacent lines of consecutive samples, from at[axis] = 0. */
static void sharpen_line(const maker *m, int axis, const size_t begin[3])
{
    float before[SIDE], *here, *next;
    size_t at[3] = {begin[0], begin[1], begin[2]};
    const size_t n = m->size[axis];
    here = m->level->samples + index_of(m->level, at[0], at[1], at[2]);
    memcpy(before, here, sizeof before);
    for (size_t i = 0; i < n; i++, here = next) {
        next = here;
        at[axis] = i + 1;
        if (i + 1 < n)
            next = m->level->samples + index_of(m->level, at[0], at[1], at[2]);
        for (int k = 0; k < SIDE; k++) {
            const float c = here[k];
            here[k] = c + SHARPER * (2 * c - before[k] - next[k]);
            before[k] = c;
        }
    }
}

/* The same along x. */
static void sharpen_row(const maker *m, const size_t begin[3])
{
    const size_t n = m->size[0];
    float before = m->level->samples[index_of(m->level, 0, begin[1], begin[2])];
    for (size_t x = 0; x < n; x += SIDE) {
        float line[SIDE + 2], *row = m->level->samples + index_of(m->level, x, begin[1], begin[2]);
        const size_t count = n - x < SIDE ? n - x : SIDE;
        line[0] = before;
        memcpy(line + 1, row, sizeof *line * SIDE);
        before = line[count];
        line[count + 1] = x + SIDE < n ? row[CVOL_LEVEL_BLOCK_SAMPLES] : before;
        for (int i = 0; i < SIDE; i++)
            row[i] = line[i + 1] + SHARPER * (2 * line[i + 1] - line[i] - line[i + 2]);
    }
}

static void sharpen(cvol_context *context, const maker *m)
{
    for (int axis = 0; axis < 3; axis++) {
        const int inner = axis == 0 ? 1 : 0, outer = 3 - axis - inner;
        const size_t step = axis == 0 ? 1 : SIDE;
#pragma omp parallel for num_threads(cvol_context_threads(context))
        for (size_t v = 0; v < m->size[outer]; v++)
            for (size_t u = 0; u < m->size[inner]; u += step) {
                size_t begin[3] = {0, 0, 0};
                begin[outer] = v;
                begin[inner] = u;
                if (axis == 0)
                    sharpen_row(m, begin);
                else
                    sharpen_line(m, axis, begin);
            }
    }
}

/* ---- blocks of the level --------------------------------------------------------------------- */

/* Repeats the last samples of a block beyond its end. */
static void extend(const maker *m, float *samples, size_t block)
{
    const size_t *blocks = m->level->shape->blocks;
    const size_t at[3] = {block % blocks[0] * SIDE, block / blocks[0] % blocks[1] * SIDE,
                          block / blocks[0] / blocks[1] * SIDE};
    if (at[0] + SIDE <= m->size[0] && at[1] + SIDE <= m->size[1] && at[2] + SIDE <= m->size[2])
        return;
    for (size_t i = 0; i < CVOL_LEVEL_BLOCK_SAMPLES; i++) {
        const size_t place[3] = {at[0] + i % SIDE, at[1] + i / SIDE % SIDE,
                                 at[2] + i / SIDE / SIDE};
        size_t from[3];
        for (int a = 0; a < 3; a++)
            from[a] = place[a] < m->size[a] ? place[a] : m->size[a] - 1;
        if (from[0] < place[0] || from[1] < place[1] || from[2] < place[2])
            samples[block * CVOL_LEVEL_BLOCK_SAMPLES + i] =
                samples[index_of(m->level, from[0], from[1], from[2])];
    }
}

static void find_bounds(float bounds[2], const float *samples)
{
    bounds[0] = bounds[1] = samples[0];
    for (size_t i = 1; i < CVOL_LEVEL_BLOCK_SAMPLES; i++) {
        bounds[0] = samples[i] < bounds[0] ? samples[i] : bounds[0];
        bounds[1] = samples[i] > bounds[1] ? samples[i] : bounds[1];
    }
}

static uint8_t find_state(const float *cover)
{
    float bounds[2];
    find_bounds(bounds, cover);
    return bounds[0] >= 1 ? CVOL_MASK_NONE : bounds[1] <= 0 ? CVOL_MASK_ALL : CVOL_MASK_SOME;
}

static int finish_blocks(cvol_context *context, const maker *m)
{
    cvol_sheet_level *level = m->level;
    const size_t count = level->shape->block_count;
    float(*bounds)[2] = cvol_allocate(count, sizeof *bounds);
    if (!bounds)
        return cvol_fail_memory(context, count * sizeof *bounds, "block ranges");
#pragma omp parallel for num_threads(cvol_context_threads(context))
    for (size_t i = 0; i < count; i++) {
        extend(m, level->samples, i);
        find_bounds(bounds[i], level->samples + i * CVOL_LEVEL_BLOCK_SAMPLES);
        if (level->cover) {
            extend(m, level->cover, i);
            level->mask.states[i] = find_state(level->cover + i * CVOL_LEVEL_BLOCK_SAMPLES);
        }
    }
    cvol_array_set_ranges(level->shape, (const float(*)[2])bounds);
    level->shape->has_ranges = 1;
    free(bounds);
    return CVOL_OK;
}

/* ---- all of it ------------------------------------------------------------------------------- */

static int allocate(cvol_context *context, maker *m, int with_cover)
{
    cvol_sheet_level *level = m->level;
    cvol_grid grid = m->array->grid;
    memcpy(grid.dims, m->size, sizeof grid.dims);
    const int code = cvol_array_create(context, &level->shape, &grid, SIDE);
    if (code)
        return code;
    const size_t samples = level->shape->block_count * CVOL_LEVEL_BLOCK_SAMPLES;
    level->shape->offset = m->array->offset;
    level->samples = cvol_allocate_zero(samples, sizeof *level->samples);
    level->cover = with_cover ? cvol_allocate_zero(samples, sizeof *level->cover) : NULL;
    level->mask.block = SIDE;
    level->mask.states = with_cover ? cvol_allocate(level->shape->block_count, 1) : NULL;
    m->bases = cvol_allocate(12 * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX, sizeof *m->bases);
    if (!level->samples || !m->bases || (with_cover && (!level->cover || !level->mask.states)))
        return cvol_fail_memory(context, samples * sizeof *level->samples, "a volume's level");
    return CVOL_OK;
}

static int make(cvol_context *context, cvol_sheet_level *out, const cvol_array *array, int level,
                int means, size_t first_slice)
{
    const int B = array->block, pitch = 1 << level, points = B / pitch;
    maker m = {.array = array,
               .level = out,
               .pitch = pitch,
               .points = points,
               .means = means,
               .first_cells = first_slice / CVOL_MASK_CELL};
    *out = (cvol_sheet_level){0};
    m.whole_points = points < 2 && !means ? 2 : points;
    m.split_points = points < 4 && !means ? 4 : points;
    m.whole_keep = means && level ? 2 * points : points; /* all terms of the level below */
    m.split_keep = m.whole_keep < 4 ? 4 : m.whole_keep;
    for (int a = 0; a < 3; a++)
        m.size[a] = cvol_sheet_level_size(array->grid.dims[a], level);
    int code = allocate(context, &m, cvol_mask_is_void(array->mask));
    if (!code) {
        m.whole = make_axes(m.bases, B, m.whole_points);
        m.split = make_axes(m.bases + 6 * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX, B, m.split_points);
        for (int k = 0; k < 2 && means; k++)
            make_means(m.bases + 6 * k * CVOL_BLOCK_MAX * CVOL_BLOCK_MAX, B, points);
        code = evaluate(context, &m);
    }
    if (!code && array->lapped)
        filter(context, &m);
    if (!code && array->mask)
        cover(context, &m);
    if (!code && !means)
        sharpen(context, &m);
    if (!code)
        code = finish_blocks(context, &m);
    free(m.bases);
    if (code)
        cvol_sheet_level_free(out);
    return code;
}

int cvol_sheet_level_make(cvol_context *context, cvol_sheet_level *out, const cvol_array *array,
                          int level)
{
    return make(context, out, array, level, 0, 0);
}

int cvol_sheet_level_make_means(cvol_context *context, cvol_sheet_level *out,
                                const cvol_array *array, int level, size_t begin, size_t end)
{
    const size_t B = (size_t)array->block, layer = array->blocks[0] * array->blocks[1];
    cvol_array slices = *array;
    slices.grid.dims[2] = end - begin;
    slices.blocks[2] = (end - begin + B - 1) / B;
    slices.block_count = slices.blocks[2] * layer;
    slices.block_table = array->block_table + begin / B * layer;
    return make(context, out, &slices, level, 1, begin);
}

void cvol_sheet_level_free(cvol_sheet_level *level)
{
    cvol_array_free(level->shape);
    free(level->samples);
    free(level->cover);
    cvol_sheet_mask_free(&level->mask);
    *level = (cvol_sheet_level){0};
}

typedef float quad __attribute__((vector_size(16)));

/* Transposes 4 x 4 samples. */
static void transpose(float *out, ptrdiff_t out_stride, const float *in, ptrdiff_t in_stride)
{
    quad a, b, c, d;
    memcpy(&a, in, sizeof a);
    memcpy(&b, in + in_stride, sizeof b);
    memcpy(&c, in + 2 * in_stride, sizeof c);
    memcpy(&d, in + 3 * in_stride, sizeof d);
    const quad lines[4] = {{a[0], b[0], c[0], d[0]},
                           {a[1], b[1], c[1], d[1]},
                           {a[2], b[2], c[2], d[2]},
                           {a[3], b[3], c[3], d[3]}};
    for (int i = 0; i < 4; i++)
        memcpy(out + i * out_stride, &lines[i], sizeof lines[i]);
}

void cvol_sheet_level_copy(float *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                           const float *from, size_t index, const cvol_sheet_plan *plan)
{
    const float *in = from + index * CVOL_LEVEL_BLOCK_SAMPLES;
    if (plan->axis_lane == 0) {
        const ptrdiff_t row = plan->axis_row == 1 ? SIDE : SIDE * SIDE,
                        sheet = SIDE * SIDE * SIDE / row;
        for (ptrdiff_t z = 0; z < SIDE; z++)
            for (ptrdiff_t y = 0; y < SIDE; y++)
                memcpy(out + z * sheet_stride + y * row_stride, in + z * sheet + y * row,
                       SIDE * sizeof *out);
        return;
    }
    for (ptrdiff_t y = 0; y < SIDE; y++) /* lanes along y, rows along z, slices along x */
        for (ptrdiff_t z = 0; z < SIDE; z += 4)
            for (ptrdiff_t x = 0; x < SIDE; x += 4)
                transpose(out + z * sheet_stride + y * row_stride + x, sheet_stride,
                          in + z + SIDE * (x + SIDE * y), SIDE);
}

void cvol_sheet_level_copy_int16(int16_t *out, ptrdiff_t row_stride, ptrdiff_t sheet_stride,
                                 const float *from, size_t index, const cvol_sheet_plan *plan)
{
    float turned[CVOL_LEVEL_BLOCK_SAMPLES] __attribute__((aligned(64)));
    cvol_sheet_level_copy(turned, SIDE, SIDE * SIDE, from, index, plan);
    CVOL_SIMD_CHOOSE(cvol_sheet_copy_int16)
    (out, row_stride, sheet_stride, turned, SIDE, SIDE * SIDE, &plan->int16);
}
