/* One HTML file with volumes. The page has comments where texts and volumes belong: web/bundle.mjs.
 */
#define _XOPEN_SOURCE 700
#include "tools/view/html_page.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

/* ---- the page without volumes -----------------------------------------------------------------
 */

/* Folders of the page, from that of the program: of an installed program, of a test, of a build. */
static const char *const places[] = {"../share/cvol/web/", "web/", "../build-web/"};

/* Finds the file `name` of the page. Exit status, after a message. */
static int find_page(char path[PATH_MAX], const char *name)
{
    char *program = realpath("/proc/self/exe", NULL);
    if (!program && errno == ENOMEM)
        return report_error(EXIT_FAILED, "not enough memory");
    char *slash = program ? strrchr(program, '/') : NULL;
    int found = 0;
    for (size_t i = 0; slash && !found && i < sizeof places / sizeof *places; i++) {
        const int length = snprintf(path, PATH_MAX, "%.*s%s%s", (int)(slash + 1 - program), program,
                                    places[i], name);
        found = length < PATH_MAX && !access(path, R_OK);
    }
    free(program);
    return found ? EXIT_DONE
                 : report_error(EXIT_FAILED,
                                "the page is not there: run make web, which needs emscripten");
}

/* Reads a file of the page, which the caller frees; NULL: an error was reported. */
static char *read_file(cvol_context *context, int *status, const char *name, size_t *bytes)
{
    char path[PATH_MAX];
    uint8_t *data = NULL;
    size_t size;
    if ((*status = find_page(path, name)))
        return NULL;
    const int code = cvol_file_read(context, &data, &size, path, 0, SIZE_MAX);
    char *text = code ? NULL : realloc(data, size + 1);
    if (!text) {
        free(data);
        *status = code ? report_context_error(context, code, NULL)
                       : report_error(EXIT_FAILED, "%s: not enough memory", path);
        return NULL;
    }
    text[size] = 0;
    *bytes = size;
    return text;
}

/* Reads a page of this version, likewise. */
static char *read_page(cvol_context *context, int *status, const char *name)
{
    char version[64];
    size_t size;
    char *text = read_file(context, status, name, &size);
    snprintf(version, sizeof version, "content=\"cvol %s\"", cvol_version());
    if (!text || strstr(text, version))
        return text;
    *status = report_error(EXIT_FAILED, "the page is of another version: run make web again");
    free(text);
    return NULL;
}

/* ---- output -----------------------------------------------------------------------------------
 */

/* A page that is being written; after a failure the functions do nothing. */
typedef struct html_page {
    cvol_context *context;
    cvol_output *out;
    int code;
} html_page;

static void put(html_page *p, const char *text, size_t size)
{
    if (!p->code)
        p->code = cvol_output_write(p->context, p->out, text, size);
}

static void put_line(html_page *p, const char *text)
{
    put(p, text, strlen(text));
}

/* Text that has no meaning in HTML. */
static void put_text(html_page *p, const char *text)
{
    for (; *text; text++) {
        char number[16];
        if (strchr("&<>\"'", *text)) {
            snprintf(number, sizeof number, "&#%d;", *text);
            put_line(p, number);
        } else {
            put(p, text, 1);
        }
    }
}

/* JSON inside an element: it cannot end the element. */
static void put_json(html_page *p, json_t *object)
{
    char *text = object && !json_lacks_memory()
                     ? json_dumps(object, JSON_COMPACT | JSON_ENSURE_ASCII)
                     : NULL;
    json_decref(object);
    if ((!text || json_lacks_memory()) && !p->code)
        p->code = CVOL_ERROR_MEMORY;
    for (const char *c = text; c && *c; c++)
        if (*c == '<')
            put_line(p, "\\u003c");
        else
            put(p, c, 1);
    free(text);
}

/* Base64 (RFC 4648). */
static void put_bytes(html_page *p, const uint8_t *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char text[4 * 4096];
    size_t filled = 0;
    for (size_t i = 0; i < size; i += 3) {
        uint32_t three = 0;
        for (size_t k = 0; k < 3; k++)
            three = three << 8 | (i + k < size ? bytes[i + k] : 0u);
        for (size_t k = 0; k < 4; k++)
            text[filled++] = i + k > size ? '=' : digits[three >> (18 - 6 * k) & 63];
        if (filled == sizeof text) {
            put(p, text, filled);
            filled = 0;
        }
    }
    put(p, text, filled);
}

/* ---- volumes ----------------------------------------------------------------------------------
 */

/* 1 if volume i is the first of its file: volumes of one file follow each other. */
static int begins_file(const view_list *list, int i)
{
    return !i || list->volumes[i].path != list->volumes[i - 1].path;
}

/* The name of file number `file` in the page; a number before it makes it unique. */
static json_t *file_name(const char *path, int file)
{
    char name[NAME_MAX + 32];
    const char *slash = strrchr(path, '/');
    if (file)
        snprintf(name, sizeof name, "%d-%s", file + 1, slash ? slash + 1 : path);
    else
        snprintf(name, sizeof name, "%s", slash ? slash + 1 : path);
    return json_text(name);
}

/* The name that the page shows; it adds those of channels. */
static const char *name_of(const viewer_volume *v)
{
    const char *slash = strrchr(v->path, '/');
    return v->name && v->channel.count < 2 ? v->name : slash ? slash + 1 : v->path;
}

/* [[value, name or null, [r, g, b] or null], ...] */
static json_t *list_labels(const viewer_volume *v)
{
    json_t *labels = json_array();
    for (size_t i = 0; i < v->label_count; i++) {
        const viewer_label *l = &v->labels[i];
        json_t *colour = l->has_colour ? json_pack("[f, f, f]", l->rgb[0], l->rgb[1], l->rgb[2])
                                       : json_null();
        json_array_append_new(
            labels,
            json_pack("[i, o, o]", l->value, l->name ? json_text(l->name) : json_null(), colour));
    }
    return labels;
}

static json_t *describe(const view_list *list, const html_texts *texts)
{
    json_t *files = json_array(), *volumes = json_array();
    int file = -1;
    for (int i = 0; i < list->count; i++) {
        const viewer_volume *v = &list->volumes[i];
        if (begins_file(list, i))
            json_array_append_new(files, file_name(v->path, ++file));
        if (v->channel.number > 0) /* the page lists the channels of the first one's file */
            continue;
        const int time = v->read.has_index && v->times < 2 ? v->read.index : -1;
        const int channel = v->read.has_channel && v->channel.count < 2 ? v->read.channel : -1;
        json_array_append_new(volumes, json_pack("{s:o, s:o, s:i, s:i, s:o}", "file",
                                                 file_name(v->path, file), "name",
                                                 json_text(name_of(v)), "time", time, "channel",
                                                 channel, "labels", list_labels(v)));
    }
    return json_pack("{s:o, s:o, s:o, s:o}", "title", json_text(texts->title), "start",
                     json_text(texts->link), "files", files, "volumes", volumes);
}

static void put_file(html_page *p, const char *path, int file)
{
    char begin[64];
    cvol_map map;
    if (p->code || (p->code = cvol_file_map(p->context, &map, path)))
        return;
    snprintf(begin, sizeof begin, "<script type=\"text/plain\" id=\"cvol-file-%d\">", file);
    put_line(p, begin);
    put_bytes(p, map.data, map.size);
    put_line(p, "</script>\n");
    cvol_file_unmap(&map);
}

static void put_volumes(html_page *p, const view_list *list, const html_texts *texts)
{
    put_line(p, "<script type=\"application/json\" id=\"cvol-about\">");
    put_json(p, describe(list, texts));
    put_line(p, "</script>\n");
    int file = 0;
    for (int i = 0; i < list->count; i++)
        if (begins_file(list, i))
            put_file(p, list->volumes[i].path, file++);
}

/* Only .cvol files of volumes, and not too many bytes of them. Exit status. */
static int check_files(const view_list *list)
{
    double bytes = 0;
    for (int i = 0; i < list->count; i++) {
        const char *path = list->volumes[i].path;
        const cvol_file_kind kind = kind_of(path);
        if (kind != CVOL_FILE_ARRAY && kind != CVOL_FILE_SERIES)
            return report_error(EXIT_FAILED,
                                "%s: is not a compressed volume: make one by cvol compress", path);
        if (begins_file(list, i))
            bytes += (double)file_size(path);
    }
    if (bytes > HTML_PAGE_BYTES_MAX)
        return report_error(EXIT_FAILED,
                            "the volumes have %.0f MB, a page holds at most %.0f MB: make them "
                            "smaller by cvol transcode",
                            bytes / 1e6, HTML_PAGE_BYTES_MAX / 1e6);
    return EXIT_DONE;
}

int write_html_page(cvol_context *context, const char *out, const view_list *list,
                    const html_texts *texts)
{
    static const char mark[] = "<!--cvol:", title[] = "<!--cvol:title-->",
                      caption[] = "<!--cvol:caption-->", volumes[] = "<!--cvol:volumes-->";
    html_page p = {context, NULL, 0};
    int status = check_files(list);
    char *page = status ? NULL : read_page(context, &status, "viewer.html");
    if (!page)
        return status;
    p.code = cvol_output_open(context, &p.out, out);
    const char *at = page;
    for (const char *next; !p.code && (next = strstr(at, mark)); at = strstr(next, "-->") + 3) {
        put(&p, at, (size_t)(next - at));
        if (!strncmp(next, title, sizeof title - 1))
            put_text(&p, *texts->title ? texts->title : name_of(&list->volumes[0]));
        else if (!strncmp(next, caption, sizeof caption - 1))
            put_text(&p, texts->caption);
        else if (!strncmp(next, volumes, sizeof volumes - 1))
            put_volumes(&p, list, texts);
    }
    put_line(&p, at);
    if (p.out)
        p.code = cvol_output_end(context, p.out, p.code);
    free(page);
    if (json_lacks_memory()) /* the context has no message */
        return report_error(EXIT_FAILED, "%s: not enough memory for the page", out);
    return p.code ? report_context_error(context, p.code, NULL) : EXIT_DONE;
}

/* Writes a file of the folder. Exit status. */
static int put_site_file(cvol_context *context, const char *folder, const char *name,
                         const char *text, size_t size)
{
    char path[PATH_MAX];
    if (snprintf(path, sizeof path, "%s/%s", folder, name) >= PATH_MAX)
        return report_error(EXIT_FAILED, "%s: the name is too long", folder);
    html_page p = {context, NULL, 0};
    p.code = cvol_output_open(context, &p.out, path);
    put(&p, text, size);
    if (p.out)
        p.code = cvol_output_end(context, p.out, p.code);
    return p.code ? report_context_error(context, p.code, NULL) : EXIT_DONE;
}

int write_site(cvol_context *context, const char *folder)
{
    int status = EXIT_DONE;
    size_t size = 0;
    char *page = read_page(context, &status, "site/index.html");
    char *script = page ? read_file(context, &status, "site/convert.js", &size) : NULL;
    if (script && mkdir(folder, 0777) && errno != EEXIST)
        status = report_error(EXIT_FAILED, "%s: cannot make this folder: %s", folder,
                              strerror(errno));
    if (!status)
        status = put_site_file(context, folder, "convert.js", script, size);
    if (!status)
        status = put_site_file(context, folder, "index.html", page, strlen(page));
    free(script);
    free(page);
    return status;
}
