/* Opening an address in a browser without telling it to others. */
#ifndef CVOL_TOOLS_BROWSER_H
#define CVOL_TOOLS_BROWSER_H

#include <limits.h>

/* A page that leads to the address, in a folder of its own; empty texts: there is none. */
typedef struct browser_page {
    char folder[PATH_MAX], file[PATH_MAX + 16];
} browser_page;

/* Hands the page to a program that shows addresses, as a process of its own, if there is a screen.
 * What cannot be done is left: the address was printed. */
void open_browser(browser_page *page, const char *address);
/* Removes it. */
void close_browser(browser_page *page);

#endif
