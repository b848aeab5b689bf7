/* The mark of labels in files of OpenVDB: the type of a grid. */
#ifndef CVOL_VOLUME_FORMATS_VDB_LABELS_H
#define CVOL_VOLUME_FORMATS_VDB_LABELS_H

#include "cvol/base.h"

/* *out: 1 if samples of this type, read from `path`, are truth values or a mask of OpenVDB; 0 for
 * others, and for what is no such file. Errors: MEMORY. */
int cvol_vdb_find_label_mark(cvol_context *context, int *out, cvol_type type, const char *path);

#endif
