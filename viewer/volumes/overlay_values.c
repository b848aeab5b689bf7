/* The values and labels of overlays at a place of the volume. They are those of the grid on which
 * the overlays are drawn. */
#include <math.h>
#include <stdlib.h>

#include "viewer/base/answer.h"
#include "viewer/volumes/labels.h"
#include "viewer/volumes/overlays.h"
#include "viewer/volumes/samples.h"

/* The nearest label, or that of the surface: "value", and "label", its name. Outside of all labels
 * both are null. */
static json_t *describe_label(const overlay *o, const viewer_overlay *given, const double at[3],
                              int on_surface)
{
    const size_t *n = o->numbers->grid.dims;
    size_t nearest[3];
    for (int a = 0; a < 3; a++)
        nearest[a] = (size_t)fmin(floor(at[a] + 0.5), (double)(n[a] - 1));
    const uint8_t *numbers = o->numbers->data;
    const int number = on_surface ? labels_number_at(o->numbers, at)
                                  : numbers[nearest[0] + n[0] * (nearest[1] + n[1] * nearest[2])];
    const viewer_label *label = number ? &given->labels[number - 1] : NULL;
    return json_pack("{s:o, s:o}", "value", label ? json_integer(label->value) : json_null(),
                     "label", answer_text(label ? label->name : NULL));
}

/* The interpolated value; null: none. NULL: an error. */
static json_t *describe_value(cvol_context *context, const overlay *o, const double at[3])
{
    const size_t *n = cvol_array_grid(o->array)->dims;
    size_t begin[3], end[3];
    double part[3], sum = 0, *values;
    for (int a = 0; a < 3; a++) {
        begin[a] = (size_t)fmin(floor(at[a]), (double)(n[a] - 1));
        end[a] = begin[a] + 2 <= n[a] ? begin[a] + 2 : n[a];
        part[a] = at[a] - (double)begin[a];
    }
    if (samples_read_array(context, &values, o->array, begin, end))
        return NULL;
    for (int k = 0; k < 8; k++) {
        size_t place = 0;
        double weight = 1;
        for (int a = 2; a >= 0; a--) {
            const size_t side = end[a] - begin[a];
            place = place * side + (k >> a & 1 && side > 1);
            weight *= k >> a & 1 ? part[a] : 1 - part[a];
        }
        if (weight > 0)
            sum += weight * values[place];
    }
    free(values);
    return json_pack("{s:o, s:n}", "value", answer_number(sum), "label");
}

json_t *overlays_describe_place(cvol_context *context, const shown_volume *v, const double place[3],
                                int on_surface)
{
    const overlay_choice all = {.on = 1};
    json_t *list = json_array();
    for (int i = 0; i < overlays_owner(v)->overlay_count; i++) {
        const overlay *o;
        held_overlay *held;
        double at[3];
        json_t *one = NULL;
        if (!overlays_hold(context, &held, &o, v, i, &all)) {
            for (int a = 0; a < 3; a++)
                at[a] = fmax(place[a] * o->share[a], 0);
            one = o->numbers ? describe_label(o, overlays_given(v, i), at, on_surface)
                             : describe_value(context, o, at);
        }
        overlays_release(v, held);
        json_array_append_new(list, one ? one : json_null());
    }
    return list;
}
