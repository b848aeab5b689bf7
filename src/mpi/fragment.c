/* Fragments of an intermediate image: fragment.h. */
#include "mpi/fragment.h"

#include <string.h>

#include "render/view/camera.h"

/* Pixels that are tested together. */
#define BLOCK 32

/* ---- blends -------------------------------------------------------------------------------- */

static void put_over(float *restrict front, const float *restrict back, size_t pixels)
{
    for (size_t i = 0; i < 4 * pixels; i += 4) {
        const float through = front[i + 3];
        for (size_t k = 0; k < 4; k++)
            front[i + k] = (k < 3 ? front[i + k] : 0) + through * back[i + k];
    }
}

static float larger(float a, float b)
{
    return a > b ? a : b;
}

static void keep_largest(float *restrict kept, const float *restrict other, size_t pixels)
{
    for (size_t i = 0; i < 2 * pixels; i++)
        kept[i] = larger(kept[i], other[i]);
}

static void keep_least(float *restrict kept, const float *restrict other, size_t pixels)
{
    for (size_t i = 0; i < 2 * pixels; i += 2) {
        kept[i] = kept[i] < other[i] ? kept[i] : other[i];
        kept[i + 1] = larger(kept[i + 1], other[i + 1]);
    }
}

/* Sums along rays, and lengths. */
static void add(float *restrict sum, const float *restrict other, size_t pixels)
{
    for (size_t i = 0; i < 2 * pixels; i++)
        sum[i] += other[i];
}

cvol_mpi_blend cvol_mpi_blend_of(cvol_mode mode)
{
    if (!cvol_mode_is_grey(mode))
        return (cvol_mpi_blend){4, 1, put_over};
    return (cvol_mpi_blend){2, 0,
                            mode == CVOL_MODE_MIP   ? keep_largest
                            : mode == CVOL_MODE_MIN ? keep_least
                                                    : add};
}

/* ---- intermediate images ------------------------------------------------------------------- */

static int is_shown(float last, const cvol_mpi_blend *blend)
{
    return (last < blend->empty) | (last > blend->empty);
}

static const float *last_values(const cvol_sheet_lines *lines, size_t group,
                                const cvol_mpi_blend *blend)
{
    return lines->values + lines->stride * group + (blend->depth - 1) * lines->count;
}

/* 1 if one of BLOCK pixels shows something: without a branch, so that compilers use vectors. */
static int is_block_shown(const float *last, const cvol_mpi_blend *blend)
{
    int any = 0;
    for (size_t i = 0; i < BLOCK; i++)
        any |= is_shown(last[i], blend);
    return any;
}

cvol_mpi_span cvol_mpi_span_of(const cvol_sheet_lines *lines, size_t group,
                               const cvol_mpi_blend *blend)
{
    const float *last = last_values(lines, group, blend);
    size_t begin = 0, end = lines->count;
    uint32_t pixels = 0, runs = 0;
    while (begin + BLOCK <= end && !is_block_shown(last + begin, blend))
        begin += BLOCK;
    while (begin < end && !is_shown(last[begin], blend))
        begin++;
    while (end >= begin + BLOCK && !is_block_shown(last + end - BLOCK, blend))
        end -= BLOCK;
    while (end > begin && !is_shown(last[end - 1], blend))
        end--;
    for (size_t i = begin; i < end; i++) {
        const int shown = is_shown(last[i], blend);
        pixels += (uint32_t)shown;
        runs += (uint32_t)(shown & (i == begin || !is_shown(last[i - 1], blend)));
    }
    return (cvol_mpi_span){(uint32_t)begin, (uint32_t)end, pixels, runs};
}

/* Adds a run; one that continues the last becomes a part of it. */
static void append_run(cvol_mpi_fragment *out, size_t first, size_t count)
{
    cvol_mpi_run *next = out->runs + out->run_count;
    if (out->run_count && next[-1].first + next[-1].count == first) {
        next[-1].count += (uint32_t)count;
        return;
    }
    *next = (cvol_mpi_run){(uint32_t)first, (uint32_t)count};
    out->run_count++;
}

/* The pixels begin .. end - 1 of a group show something. */
static void read_run(cvol_mpi_fragment *out, const cvol_sheet_lines *lines, size_t group,
                     size_t begin, size_t end, const cvol_mpi_blend *blend)
{
    const size_t depth = blend->depth;
    const float *from = lines->values + lines->stride * group;
    float *to = out->values + depth * out->pixel_count;
    append_run(out, lines->count * group + begin, end - begin);
    for (size_t k = 0; k < depth; k++)
        for (size_t i = begin; i < end; i++)
            to[depth * (i - begin) + k] = from[lines->count * k + i];
    out->pixel_count += end - begin;
}

void cvol_mpi_fragment_read(cvol_mpi_fragment *out, const cvol_sheet_lines *lines,
                            const cvol_mpi_span *spans, const cvol_mpi_blend *blend)
{
    out->run_count = out->pixel_count = 0;
    for (size_t g = 0; g < lines->groups; g++) {
        const float *last = last_values(lines, g, blend);
        const size_t stop = spans[g].end;
        for (size_t begin = spans[g].begin, end; begin < stop; begin = end) {
            while (begin < stop && !is_shown(last[begin], blend))
                begin++;
            for (end = begin; end < stop && is_shown(last[end], blend);)
                end++;
            if (begin < end)
                read_run(out, lines, g, begin, end, blend);
        }
    }
}

void cvol_mpi_fragment_write(const cvol_sheet_lines *lines, const cvol_mpi_fragment *fragment,
                             const cvol_mpi_blend *blend)
{
    const size_t n = lines->count, depth = blend->depth;
    const float *from = fragment->values;
    for (size_t r = 0; r < fragment->run_count; r++) {
        const cvol_mpi_run run = fragment->runs[r];
        size_t group = run.first / n, i = run.first % n;
        for (uint32_t left = run.count; left > 0; left--, from += depth) {
            for (size_t k = 0; k < depth; k++)
                lines->values[lines->stride * group + n * k + i] = from[k];
            if (++i == n) {
                i = 0;
                group++;
            }
        }
    }
}

/* ---- messages ------------------------------------------------------------------------------ */

size_t cvol_mpi_message_cells(size_t runs, size_t pixels, const cvol_mpi_blend *blend)
{
    return 1 + runs + pixels * blend->depth / 2;
}

size_t cvol_mpi_message_most(size_t pixels, const cvol_mpi_blend *blend)
{
    return cvol_mpi_message_cells((pixels + 1) / 2, pixels, blend);
}

cvol_mpi_cursor cvol_mpi_cursor_of(const cvol_mpi_fragment *fragment)
{
    return (cvol_mpi_cursor){.run = fragment->runs,
                             .end = fragment->runs + fragment->run_count,
                             .values = fragment->values};
}

cvol_mpi_fragment cvol_mpi_fragment_of_message(cvol_mpi_run *message)
{
    cvol_mpi_run *runs = message + 1;
    return (cvol_mpi_fragment){.run_count = message->first,
                               .pixel_count = message->count,
                               .runs = runs,
                               .values = (float *)(runs + message->first)};
}

/* The number of the next pixel; SIZE_MAX at the end. */
static size_t next_pixel(const cvol_mpi_cursor *cursor)
{
    return cursor->run < cursor->end ? (size_t)cursor->run->first + cursor->done : SIZE_MAX;
}

static size_t end_of_run(const cvol_mpi_cursor *cursor)
{
    return (size_t)cursor->run->first + cursor->run->count;
}

/* Moves behind `count` pixels of the run. */
static void advance(cvol_mpi_cursor *cursor, size_t count, size_t depth)
{
    cursor->values += depth * count;
    cursor->done += (uint32_t)count;
    if (cursor->done == cursor->run->count) {
        cursor->done = 0;
        cursor->run++;
    }
}

size_t cvol_mpi_message_cut(cvol_mpi_run *message, cvol_mpi_cursor *cursor, size_t end,
                            const cvol_mpi_blend *blend)
{
    const float *values = cursor->values;
    cvol_mpi_fragment out = {.runs = message + 1};
    for (size_t at; (at = next_pixel(cursor)) < end;) {
        const size_t stop = end_of_run(cursor), count = (stop < end ? stop : end) - at;
        append_run(&out, at, count);
        out.pixel_count += count;
        advance(cursor, count, blend->depth);
    }
    memcpy(message + 1 + out.run_count, values, out.pixel_count * blend->depth * sizeof *values);
    *message = (cvol_mpi_run){(uint32_t)out.run_count, (uint32_t)out.pixel_count};
    return cvol_mpi_message_cells(out.run_count, out.pixel_count, blend);
}

/* The end of the pixels, from `at` on, that the same cursors have. */
static size_t end_of_overlap(const cvol_mpi_cursor *cursors, size_t count, size_t at)
{
    size_t end = SIZE_MAX;
    for (size_t c = 0; c < count; c++) {
        const size_t next = next_pixel(&cursors[c]),
                     change = next == at ? end_of_run(&cursors[c]) : next;
        end = change < end ? change : end;
    }
    return end;
}

void cvol_mpi_fragment_merge(cvol_mpi_fragment *out, cvol_mpi_cursor *cursors, size_t count,
                             const cvol_mpi_blend *blend)
{
    out->run_count = out->pixel_count = 0;
    for (;;) {
        size_t at = SIZE_MAX;
        for (size_t c = 0; c < count; c++) {
            const size_t next = next_pixel(&cursors[c]);
            at = next < at ? next : at;
        }
        if (at == SIZE_MAX)
            return;
        const size_t pixels = end_of_overlap(cursors, count, at) - at;
        float *to = out->values + blend->depth * out->pixel_count;
        int is_first = 1;
        for (size_t c = 0; c < count; c++) {
            if (next_pixel(&cursors[c]) != at)
                continue;
            if (is_first)
                memcpy(to, cursors[c].values, pixels * blend->depth * sizeof *to);
            else
                blend->put(to, cursors[c].values, pixels);
            is_first = 0;
            advance(&cursors[c], pixels, blend->depth);
        }
        append_run(out, at, pixels);
        out->pixel_count += pixels;
    }
}
