/* The files of the page. */
#include "viewer/http/page.h"

#include <string.h>

#include "viewer/http/page_files.h"

static const char *type_of(const char *name)
{
    static const char *const types[][2] = {{".html", "text/html; charset=utf-8"},
                                           {".css", "text/css; charset=utf-8"},
                                           {".js", "text/javascript; charset=utf-8"},
                                           {".svg", "image/svg+xml"},
                                           {".png", "image/png"}};
    const char *ending = strrchr(name, '.');
    for (size_t i = 0; ending && i < sizeof types / sizeof *types; i++)
        if (!strcmp(ending, types[i][0]))
            return types[i][1];
    return "application/octet-stream";
}

answer page_file(const char *path)
{
    const char *name = *path ? path : "index.html";
    for (size_t i = 0; i < page_file_count; i++)
        if (!strcmp(page_files[i].name, name)) {
            union {
                const unsigned char *in;
                void *out;
            } bytes = {.in = page_files[i].bytes};
            return answer_bytes(type_of(name), bytes.out, page_files[i].size, NULL);
        }
    return (answer){0};
}
