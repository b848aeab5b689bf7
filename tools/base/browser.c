/* Opens an address in a browser. Every user of a machine can read the arguments of programs (ps),
 * and the address holds a secret token. So xdg-open gets the name of a file that only its owner can
 * read; the page in it leads to the address. */
#define _XOPEN_SOURCE 700
#include "tools/base/browser.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* Writes text as HTML that is safe inside and outside quotes. */
static void put_text(FILE *out, const char *text)
{
    for (; *text; text++)
        if (strchr("&<>\"'", *text))
            fprintf(out, "&#%d;", *text);
        else
            fputc(*text, out);
}

static void put_page(FILE *out, const char *address)
{
    fputs("<!doctype html><meta charset=\"utf-8\"><title>cvol view</title>"
          "<meta name=\"referrer\" content=\"no-referrer\">"
          "<meta http-equiv=\"refresh\" content=\"0; url=",
          out);
    put_text(out, address);
    fputs("\"><a href=\"", out);
    put_text(out, address);
    fputs("\">cvol view</a>\n", out);
}

/* Makes a folder that only its owner can open, and the page in it. */
static int make_page(browser_page *page, const char *address)
{
    const char *place = getenv("TMPDIR");
    const int length = snprintf(page->folder, sizeof page->folder, "%s/cvol-view-XXXXXX",
                                place && *place == '/' ? place : "/tmp");
    page->file[0] = 0;
    if (length < 0 || (size_t)length >= sizeof page->folder || !mkdtemp(page->folder)) {
        page->folder[0] = 0;
        return 0;
    }
    snprintf(page->file, sizeof page->file, "%s/view.html", page->folder);
    const int fd = open(page->file, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    FILE *out = fd < 0 ? NULL : fdopen(fd, "w");
    if (!out) {
        if (fd >= 0)
            close(fd);
        return 0;
    }
    put_page(out, address);
    return !fclose(out);
}

static void start(const char *file)
{
    const pid_t child = fork();
    if (child > 0)
        waitpid(child, NULL, 0);
    if (child)
        return;
    if (fork()) /* its parent ends at once: no process has to wait for the browser */
        _exit(0);
    const int quiet = open("/dev/null", O_RDWR);
    if (quiet >= 0) {
        dup2(quiet, STDOUT_FILENO);
        dup2(quiet, STDERR_FILENO);
    }
    execlp("xdg-open", "xdg-open", file, (char *)NULL);
    _exit(127);
}

void open_browser(browser_page *page, const char *address)
{
    page->folder[0] = page->file[0] = 0;
    if (!getenv("DISPLAY") && !getenv("WAYLAND_DISPLAY"))
        return;
    if (make_page(page, address))
        start(page->file);
}

void close_browser(browser_page *page)
{
    if (page->file[0])
        unlink(page->file);
    if (page->folder[0])
        rmdir(page->folder);
}
