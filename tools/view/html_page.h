/* One HTML file with volumes, and the page that opens files, from those that make web builds. */
#ifndef CVOL_TOOLS_HTML_PAGE_H
#define CVOL_TOOLS_HTML_PAGE_H

#include "tools/view/view_list.h"

/* The largest total of the files in a page, in bytes. */
#define HTML_PAGE_BYTES_MAX 200e6

/* Texts of a page; each may be empty. */
typedef struct html_texts {
    const char *title, *caption;
    const char *link; /* the view at first: the part of a link from its # */
} html_texts;

/* Writes the page; `list` has volumes of .cvol files. Exit status. */
int write_html_page(cvol_context *context, const char *out, const view_list *list,
                    const html_texts *texts);

/* Writes the files of the page that opens volumes into a folder, which it makes. Exit status. */
int write_site(cvol_context *context, const char *folder);

#endif
