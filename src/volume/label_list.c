/* Names and colours of labels that files of volumes state. */
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "volume/formats/label_list.h"
#include "volume/io/stored.h"
#include "volume/io/text.h"

int cvol_label_list_add(cvol_context *context, cvol_label_list *list, int value, const char *name,
                        size_t size, const double *rgb, const char *path)
{
    if (list->count >= CVOL_LABELS_MOST)
        return cvol_fail(context, CVOL_ERROR_LIMIT, "%s: has more than %d labels", path,
                         (int)CVOL_LABELS_MOST);
    if (!(list->count & (list->count - 1))) { /* full: 0 or a power of two */
        const size_t room = list->count ? 2 * list->count : 1;
        cvol_listed_label *more = realloc(list->labels, room * sizeof *more);
        if (!more)
            return cvol_fail_memory(context, room * sizeof *more, path);
        list->labels = more;
    }
    cvol_channel_label checked;
    _Static_assert(sizeof checked.name == CVOL_LABEL_NAME_BYTES, "names have the same size");
    cvol_labels_set_name(&checked, name, size);
    cvol_listed_label *label = &list->labels[list->count++];
    *label = (cvol_listed_label){.value = value, .rgb = {-1, -1, -1}};
    memcpy(label->name, checked.name, sizeof label->name);
    if (rgb)
        memcpy(label->rgb, rgb, sizeof label->rgb);
    return CVOL_OK;
}

/* One block: the labels, and their names behind them. */
static cvol_label *make_block(const cvol_label_list *list)
{
    cvol_label *labels = cvol_allocate(list->count, sizeof *labels + CVOL_LABEL_NAME_BYTES);
    for (size_t i = 0; labels && i < list->count; i++) {
        char *name = (char *)(labels + list->count) + i * CVOL_LABEL_NAME_BYTES;
        memcpy(name, list->labels[i].name, CVOL_LABEL_NAME_BYTES);
        labels[i] = (cvol_label){.value = list->labels[i].value, .name = name};
        memcpy(labels[i].rgb, list->labels[i].rgb, sizeof labels[i].rgb);
    }
    return labels;
}

int cvol_label_list_read(cvol_context *context, cvol_label **out, size_t *count, const char *path)
{
    cvol_label_list list = {0};
    *out = NULL;
    *count = 0;
    int code = CVOL_OK;
    if (cvol_text_ends(path, ".nii") || cvol_text_ends(path, ".nii.gz"))
        code = cvol_nifti_list_labels(context, &list, path);
    else if (cvol_text_ends(path, ".mgh") || cvol_text_ends(path, ".mgz") ||
             cvol_text_ends(path, ".mgh.gz"))
        code = cvol_mgh_list_labels(context, &list, path);
    if (!code && list.count && !(*out = make_block(&list)))
        code = cvol_fail_memory(context, list.count * sizeof **out, path);
    if (!code)
        *count = list.count;
    free(list.labels);
    return code;
}
