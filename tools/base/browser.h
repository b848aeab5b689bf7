/* Opens an address in a browser; other users of the machine do not see it. */
#ifndef CVOL_TOOLS_BROWSER_H
#define CVOL_TOOLS_BROWSER_H

#include <limits.h>

/* A page that leads to the address, in its own folder. Empty texts: there is no page. */
typedef struct browser_page {
    char folder[PATH_MAX], file[PATH_MAX + 16];
} browser_page;

/* Starts a program that shows the page, as a separate process, if there is a screen. Ignores
 * failures: the user sees the printed address. */
void open_browser(browser_page *page, const char *address);
/* Removes page and folder. */
void close_browser(browser_page *page);

#endif
