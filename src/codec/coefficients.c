/* Gather, transform, and put in scan order. */
#include "codec/coefficients.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "codec/block_model.h"
#include "transform/block.h"

/* Transforms block `index` into out; its largest magnitude. */
static float transform_block(float *out, float *work, const cvol_array *shape, const void *samples,
                             size_t index)
{
    const cvol_scan *scan = cvol_scan_of(shape->block);
    float *spectrum = work + scan->count, largest = 0;
    cvol_block_gather(work, samples, &shape->grid, shape->block, index, shape->offset);
    cvol_block_forward(spectrum, work, shape->block);
    for (int i = 0; i < scan->count; i++) {
        out[i] = spectrum[scan->entries[i].place];
        largest = fabsf(out[i]) > largest ? fabsf(out[i]) : largest;
    }
    return largest;
}

int cvol_coefficients_make(cvol_context *context, cvol_coefficients *out, const cvol_array *shape,
                           const void *samples)
{
    const size_t per_block = (size_t)shape->block * (size_t)shape->block * (size_t)shape->block;
    size_t count;
    out->largest = 0;
    out->data = NULL;
    if (cvol_size_multiply(&count, shape->block_count, per_block))
        out->data = cvol_allocate(count, sizeof(float));
    if (!out->data)
        return cvol_fail_memory(context, count * sizeof(float), "the volume's coefficients");
    float largest = 0;
    int failed = 0;
#pragma omp parallel num_threads(cvol_context_threads(context)) reduction(max : largest)
    {
        float *work = cvol_allocate(2 * per_block, sizeof *work);
        if (!work) {
#pragma omp atomic write
            failed = 1;
        }
#pragma omp for schedule(dynamic, 16)
        for (size_t i = 0; i < shape->block_count; i++)
            if (work) {
                float most = transform_block(out->data + i * per_block, work, shape, samples, i);
                largest = most > largest ? most : largest;
            }
        free(work);
    }
    out->largest = largest;
    if (failed) {
        cvol_coefficients_free(out);
        return cvol_fail_memory(context, 2 * per_block * sizeof(float), "a block");
    }
    return cvol_report_progress(context, "compressing", 0.1);
}

void cvol_coefficients_free(cvol_coefficients *coefficients)
{
    free(coefficients->data);
    coefficients->data = NULL;
}
