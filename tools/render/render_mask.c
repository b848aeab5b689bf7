/* Samples without a value: from the mask of an array, or marked in dense samples. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_options.h"

static double float_sample(const cvol_volume *volume, size_t i)
{
    return volume->grid.type == CVOL_FLOAT64 ? ((const double *)volume->data)[i]
                                             : (double)((const float *)volume->data)[i];
}

/* 1 if there are NaN samples and no infinite ones, which compression refuses. */
static int has_nan_alone(const cvol_volume *volume)
{
    const size_t count = cvol_grid_samples(&volume->grid);
    int has_nan = 0;
    if (cvol_type_is_integer(volume->grid.type))
        return 0;
    for (size_t i = 0; i < count; i++) {
        if (isinf(float_sample(volume, i)))
            return 0;
        has_nan |= isnan(float_sample(volume, i));
    }
    return has_nan;
}

/* Treats dense samples of a value far from all others, and NaN, as missing. Exit status. */
int find_marks(cvol_context *context, scene *s, const char *path)
{
    cvol_histogram histogram;
    if (s->in.volume && has_nan_alone(s->in.volume)) {
        s->in.has_fill = 1;
        s->in.fill = NAN;
    }
    const int code = s->in.volume ? cvol_volume_compute_histogram(context, &histogram, s->in.volume)
                                  : 0;
    if (code)
        return report_context_error(context, code, path);
    if (!s->in.volume || !histogram.mark_count)
        return EXIT_DONE;
    s->in.has_fill = 1;
    s->in.fill = histogram.mark;
    clear_progress();
    fprintf(stderr,
            "cvol: %s: samples of %g, far from all others, are treated as missing; cvol compress "
            "--fill "
            "stores that\n",
            path, histogram.mark);
    return EXIT_DONE;
}

/* Stores a value as bytes in the type of the samples. */
static void encode(uint8_t out[8], double value, cvol_type type)
{
    const float single = (float)value;
    const int64_t whole = cvol_type_is_integer(type) ? (int64_t)value : 0;
    const uint8_t bits8 = (uint8_t)whole;
    const uint16_t bits16 = (uint16_t)whole;
    const uint32_t bits32 = (uint32_t)whole;
    if (type == CVOL_FLOAT64)
        memcpy(out, &value, sizeof value);
    else if (type == CVOL_FLOAT32)
        memcpy(out, &single, sizeof single);
    else
        memcpy(out,
               cvol_type_size(type) == 1   ? (const void *)&bits8
               : cvol_type_size(type) == 2 ? (const void *)&bits16
                                           : (const void *)&bits32,
               cvol_type_size(type));
}

static void find_marked(uint8_t *mask, const cvol_volume *volume, double mark)
{
    const size_t count = cvol_grid_samples(&volume->grid);
    const size_t size = cvol_type_size(volume->grid.type);
    const uint8_t *samples = volume->data;
    const int is_float = !cvol_type_is_integer(volume->grid.type);
    uint8_t bytes[8];
    encode(bytes, mark, volume->grid.type);
    for (size_t i = 0; i < count; i++)
        mask[i] = !memcmp(samples + i * size, bytes, size) ||
                  (is_float && isnan(float_sample(volume, i)));
}

int find_mask(scene *s)
{
    if (!s->in.array && !s->in.has_fill)
        return EXIT_DONE;
    const cvol_grid *grid = input_grid(&s->in);
    const size_t begin[3] = {0, 0, 0}, count = cvol_grid_samples(grid);
    s->mask = malloc(count);
    if (!s->mask)
        return report_error(EXIT_FAILED, "not enough memory for a mask of %zu samples", count);
    if (!s->in.array) {
        find_marked(s->mask, s->in.volume, s->in.fill);
    } else if (!cvol_array_evaluate_mask(s->mask, s->in.array, begin, grid->dims)) {
        free(s->mask);
        s->mask = NULL;
    }
    return EXIT_DONE;
}
