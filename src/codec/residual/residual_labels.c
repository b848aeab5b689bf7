/* Decodes labels in place of a residual. */
#include "codec/residual/residual_labels.h"

#include <math.h>

#include "base/for_type.h"

int cvol_labels_rule_valid(const cvol_residual_rule *rule)
{
    return cvol_type_is_integer(rule->type) && rule->quantum >= rule->value_min &&
           rule->quantum <= rule->value_max && floor(rule->quantum) == rule->quantum;
}

uint32_t cvol_labels_usual(const cvol_residual_rule *rule)
{
    return (uint32_t)(rule->quantum - rule->value_min);
}

uint32_t cvol_labels_most(const cvol_residual_rule *rule)
{
    return (uint32_t)(rule->value_max - rule->value_min);
}

static void put_samples(void *samples, const uint32_t *numbers, const cvol_residual_rule *rule,
                        size_t count)
{
    const int64_t least = (int64_t)rule->value_min;
#define PUT(t)                         \
    for (size_t i = 0; i < count; i++) \
    ((t *)samples)[i] = (t)(least + numbers[i])
    CVOL_FOR_TYPE(rule->type, PUT);
#undef PUT
}

int cvol_labels_decode(cvol_label_coder *coder, void *samples, uint32_t *numbers,
                       const cvol_residual_rule *rule, const size_t size[3], cvol_span data)
{
    const size_t count = size[0] * size[1] * size[2];
    const cvol_label_brick brick = {
        .size = {size[0], size[1], size[2]}, .most = cvol_labels_most(rule), .labels = numbers};
    int code = CVOL_OK;
    if (data.size)
        code = cvol_label_decode(coder, &brick, data);
    for (size_t i = 0; i < count && !data.size; i++)
        numbers[i] = cvol_labels_usual(rule);
    if (!code)
        put_samples(samples, numbers, rule, count);
    return code;
}
