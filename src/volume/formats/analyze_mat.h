/* The geometry that SPM stores next to an image of Analyze, in NAME.mat. */
#ifndef CVOL_VOLUME_FORMATS_ANALYZE_MAT_H
#define CVOL_VOLUME_FORMATS_ANALYZE_MAT_H

#include "cvol/base.h"

/* Sets the grid's geometry by the matrix `mat` or `M` of the file, if there is such a file of
 * MATLAB 4; other files are ignored, but for those of MATLAB 5, which are UNSUPPORTED. Errors: IO,
 * LIMIT, MEMORY, FORMAT (no invertible matrix). */
int cvol_analyze_read_mat(cvol_context *context, cvol_grid *grid, const char *path);

#endif
