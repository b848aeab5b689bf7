/* Names and colours of labels that files state, while they are read (cvol_label_list_read). */
#ifndef CVOL_VOLUME_FORMATS_LABEL_LIST_H
#define CVOL_VOLUME_FORMATS_LABEL_LIST_H

#include "cvol/volume.h"

enum { CVOL_LABEL_NAME_BYTES = 64, CVOL_LABELS_MOST = 65536 };

typedef struct cvol_listed_label {
    int value;
    char name[CVOL_LABEL_NAME_BYTES]; /* UTF-8, with a zero */
    double rgb[3];                    /* rgb[0] -1: no colour */
} cvol_listed_label;

typedef struct cvol_label_list {
    cvol_listed_label *labels; /* freed with free() */
    size_t count;
} cvol_label_list;

/* Adds a label with `size` bytes of name; rgb NULL: no colour. Names that are not UTF-8 are "".
 * Errors: MEMORY, LIMIT (CVOL_LABELS_MOST). */
int cvol_label_list_add(cvol_context *context, cvol_label_list *list, int value, const char *name,
                        size_t size, const double *rgb, const char *path);

/* Add the labels of a file of the format; of another file none. Errors: IO, MEMORY, LIMIT, FORMAT
 * (a damaged stream). A table that is damaged ends the list. */
int cvol_nifti_list_labels(cvol_context *context, cvol_label_list *list, const char *path);
int cvol_mgh_list_labels(cvol_context *context, cvol_label_list *list, const char *path);

#endif
