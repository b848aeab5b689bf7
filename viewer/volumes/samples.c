/* Decoded samples of a volume. */
#include "viewer/volumes/samples.h"

#include <math.h>
#include <stdlib.h>

#include "viewer/base/answer.h"
#include "viewer/volumes/labels.h"
#include "viewer/volumes/overlays.h"

/* A sample of a type as a number. */
static double number_at(const void *data, cvol_type type, size_t i)
{
    switch (type) {
    case CVOL_UINT8:
        return ((const uint8_t *)data)[i];
    case CVOL_INT8:
        return ((const int8_t *)data)[i];
    case CVOL_UINT16:
        return ((const uint16_t *)data)[i];
    case CVOL_INT16:
        return ((const int16_t *)data)[i];
    case CVOL_UINT32:
        return ((const uint32_t *)data)[i];
    case CVOL_INT32:
        return ((const int32_t *)data)[i];
    case CVOL_FLOAT32:
        return (double)((const float *)data)[i];
    case CVOL_FLOAT64:
        return ((const double *)data)[i];
    }
    return NAN;
}

int samples_read_array(cvol_context *context, double **out, const cvol_array *array,
                       const size_t begin[3], const size_t end[3])
{
    const cvol_type type = cvol_array_grid(array)->type;
    size_t count = 1;
    *out = NULL;
    for (int a = 0; a < 3; a++) {
        const size_t side = end[a] - begin[a];
        if (side && count > SIZE_MAX / sizeof(double) / side)
            return CVOL_ERROR_MEMORY;
        count *= side;
    }
    void *stored = calloc(count, cvol_type_size(type));
    uint8_t *mask = calloc(count, 1);
    double *numbers = calloc(count, sizeof *numbers);
    int code = stored && mask && numbers
                   ? cvol_array_evaluate_box(context, stored, array, begin, end)
                   : CVOL_ERROR_MEMORY;
    if (!code) {
        cvol_array_evaluate_mask(mask, array, begin, end);
        for (size_t i = 0; i < count; i++)
            numbers[i] = mask[i] ? NAN : number_at(stored, type, i);
        *out = numbers;
        numbers = NULL;
    }
    free(stored);
    free(mask);
    free(numbers);
    return code;
}

int samples_read(cvol_context *context, double **out, const shown_volume *v, const size_t begin[3],
                 const size_t end[3])
{
    return samples_read_array(context, out, v->array, begin, end);
}

/* The position in the world, see cvol_grid. */
static json_t *world_of(const cvol_grid *g, const double place[3])
{
    double world[3];
    for (int i = 0; i < 3; i++) {
        world[i] = g->origin[i];
        for (int a = 0; a < 3; a++)
            world[i] += g->direction[a][i] * g->spacing[a] * place[a];
    }
    return json_pack("[f, f, f]", world[0], world[1], world[2]);
}

int samples_describe(cvol_context *context, json_t **out, const shown_volume *v,
                     const double place[3])
{
    size_t begin[3], end[3];
    double *value;
    for (int a = 0; a < 3; a++) {
        const double last = (double)(v->grid.dims[a] - 1);
        begin[a] = (size_t)fmin(fmax(floor(place[a] + 0.5), 0), last);
        end[a] = begin[a] + 1;
    }
    *out = NULL;
    const int code = samples_read(context, &value, v, begin, end);
    if (code)
        return code;
    const int known = fabs(v->rescale[0]) > 0;
    const char *label = labels_name(v, *value);
    json_t *object = json_pack("{s:o, s:o, s:o, s:o}", "value", answer_number(*value), "meaning",
                               answer_number(known ? v->rescale[0] * *value + v->rescale[1] : NAN),
                               "label", answer_text(label), "world", world_of(&v->grid, place));
    free(value);
    json_object_set_new(object, "overlays", overlays_describe_place(context, v, place, 0));
    *out = object;
    return object ? CVOL_OK : CVOL_ERROR_MEMORY;
}
