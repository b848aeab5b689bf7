/* Chooses the base's step by the bytes of base and residual together. It tries both on a box in the
 * middle of the volume, from a fine step to coarser ones while the bytes decrease. The best step
 * depends on the share of noise in the samples (residual_step.h). */
#include "codec/rate/residual_step.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/rate/encode_attempt.h"
#include "codec/residual/make_residual.h"

enum {
    PART_SIDE = 128, /* of the box that steps are tried on */
    STEPS_MAX = 16
};

/* The middle of the volume, for trying steps. */
typedef struct part {
    cvol_grid grid;
    void *samples;
    cvol_mask *mask;
    cvol_attempt attempt;
} part;

static void part_free(part *p)
{
    free(p->samples);
    cvol_mask_free(p->mask);
    cvol_attempt_free(&p->attempt);
    free(p);
}

/* The box of whole cells around the middle. */
static void part_box(size_t begin[3], size_t end[3], const cvol_grid *grid)
{
    for (int a = 0; a < 3; a++) {
        begin[a] = grid->dims[a] > PART_SIDE ? (grid->dims[a] - PART_SIDE) / 2 / 16 * 16 : 0;
        end[a] = grid->dims[a] > PART_SIDE ? begin[a] + PART_SIDE : grid->dims[a];
    }
}

static int part_make(cvol_context *context, part **out, const cvol_residual_step_input *q)
{
    const size_t *dims = q->grid->dims, size = cvol_type_size(q->grid->type);
    size_t begin[3], end[3];
    part *p = calloc(1, sizeof *p);
    *out = p;
    if (!p)
        return cvol_fail_memory(context, sizeof *p, "a part of the volume");
    part_box(begin, end, q->grid);
    p->grid = *q->grid;
    for (int a = 0; a < 3; a++)
        p->grid.dims[a] = end[a] - begin[a];
    p->samples = cvol_allocate(cvol_grid_samples(&p->grid), size);
    if (!p->samples)
        return cvol_fail_memory(context, cvol_grid_bytes(&p->grid), "a part of the volume");
    uint8_t *to = p->samples;
    for (size_t z = begin[2]; z < end[2]; z++)
        for (size_t y = begin[1]; y < end[1]; y++, to += size * p->grid.dims[0])
            memcpy(to,
                   (const uint8_t *)q->samples + size * (begin[0] + dims[0] * (y + dims[1] * z)),
                   size * p->grid.dims[0]);
    int code = CVOL_OK;
    if (q->mask) {
        const size_t zero[3] = {0, 0, 0};
        uint8_t *which = cvol_allocate(cvol_grid_samples(&p->grid), 1);
        code = which ? cvol_mask_create(context, &p->mask, p->grid.dims, cvol_mask_fills(q->mask))
                     : cvol_fail_memory(context, cvol_grid_samples(&p->grid), "a mask");
        if (!code) {
            cvol_mask_get(which, q->mask, begin, end);
            if (!cvol_mask_set(p->mask, which, zero, p->grid.dims))
                code = cvol_fail_memory(context, cvol_grid_samples(&p->grid), "a mask");
        }
        free(which);
    }
    if (!code)
        code = cvol_attempt_start(context, &p->attempt, p->samples, &p->grid, q->options);
    if (!code)
        cvol_attempt_set_options(&p->attempt, q->options);
    return code;
}

/* Bytes of base and residual of the box; infinity if the step is too fine. */
static int try_part(cvol_context *context, part *p, double bound, double step, double *bytes)
{
    cvol_residual_job job;
    uint64_t size;
    *bytes = (double)INFINITY;
    int code = cvol_attempt_encode(context, &p->attempt, step);
    if (code == CVOL_ERROR_TARGET)
        return CVOL_OK;
    if (!code)
        code = cvol_attempt_decode(context, &p->attempt);
    if (code)
        return code;
    cvol_array *array = p->attempt.array;
    array->mask = p->mask;
    code = cvol_residual_job_start(&job, array, p->samples, bound);
    job.tables = p->attempt.tables;
    if (!code)
        code = cvol_residual_job_run(context, &job, NULL, &size, NULL);
    array->mask = NULL;
    if (code == CVOL_ERROR_TARGET)
        return CVOL_OK;
    if (!code)
        *bytes = (double)size + (double)p->attempt.result.bytes;
    return code == CVOL_ERROR_MEMORY ? cvol_fail_memory(context, 1 << 22, "a brick") : code;
}

/* The finest step to try, and its growth factor. */
static double first_step(const cvol_residual_step_input *q, double *factor)
{
    const double span = q->whole->error_bound.value_max - q->whole->error_bound.value_min;
    *factor = 2;
    if (cvol_type_is_integer(q->grid->type))
        return q->bound >= 1 ? 2 * floor(q->bound) + 1 : 1;
    if (q->bound > 0)
        return 2 * q->bound;
    *factor = 4;
    return ldexp(span, -15);
}

/* Tries coarser steps while that helps, then steps in between. */
int cvol_residual_step(cvol_context *context, double *best, const cvol_residual_step_input *q)
{
    part *p;
    double factor, least = (double)INFINITY;
    int code = part_make(context, &p, q), worse = 0;
    if (!code) {
        const cvol_array *shape = p->attempt.shape;
        const double span = shape->error_bound.value_max - shape->error_bound.value_min;
        double step = first_step(q, &factor);
        *best = step;
        for (int i = 0; i < STEPS_MAX && !code && worse < 2; i++, step *= factor) {
            double bytes;
            if (i && step > 2 * span)
                break;
            code = try_part(context, p, q->bound, step, &bytes);
            worse = bytes < least ? 0 : worse + (isfinite(least) != 0);
            if (bytes < least) {
                least = bytes;
                *best = step;
            }
        }
        for (int side = 0; side < 2 && !code; side++) {
            const double between = *best * (side ? sqrt(factor) : 1 / sqrt(factor));
            double bytes;
            code = try_part(context, p, q->bound, between, &bytes);
            if (!code && bytes < least) {
                least = bytes;
                *best = between;
                break;
            }
        }
    }
    if (p)
        part_free(p);
    return code;
}
