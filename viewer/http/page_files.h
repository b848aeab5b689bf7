/* The files of viewer/page/, embedded by cmake/embed.cmake. */
#ifndef CVOL_VIEWER_HTTP_PAGE_FILES_H
#define CVOL_VIEWER_HTTP_PAGE_FILES_H

#include <stddef.h>

typedef struct page_file_entry {
    const char *name;
    const unsigned char *bytes;
    size_t size;
} page_file_entry;

extern const page_file_entry page_files[];
extern const size_t page_file_count;

#endif
