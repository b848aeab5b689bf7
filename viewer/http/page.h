/* The files of the page, which are part of the program. */
#ifndef CVOL_VIEWER_HTTP_PAGE_H
#define CVOL_VIEWER_HTTP_PAGE_H

#include "viewer/base/answer.h"

/* The file at a path ("": index.html); status 0: no such file. */
answer page_file(const char *path);

#endif
