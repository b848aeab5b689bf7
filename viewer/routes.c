/* From paths to handlers. */
#include <stdio.h>
#include <string.h>

#include "command.h"
#include "copy.h"
#include "difference.h"
#include "film_out.h"
#include "films.h"
#include "frame.h"
#include "page.h"
#include "pick.h"
#include "request.h"
#include "slice.h"
#include "transfer.h"
#include "volume_renderers.h"

static answer service_get(request *r)
{
    const service *s = r->service;
    json_t *transfers = json_array(), *ct = json_array(), *formats = json_array();
    const struct {
        json_t *list;
        const char *names;
    } lists[] = {{transfers, cvol_transfer_names()}, {ct, cvol_transfer_ct_names()}};
    for (int i = 0; i < 2; i++)
        for (const char *name = lists[i].names; *name;) {
            const size_t length = strcspn(name, " ");
            json_array_append_new(lists[i].list, json_stringn(name, length));
            name += length + strspn(name + length, " ");
        }
    const film_format *format;
    for (int i = 0; (format = film_format_at(i, s->options->movies)); i++)
        json_array_append_new(formats, json_string(format->name));
    return answer_json(200, json_pack("{s:i, s:s, s:i, s:b, s:{s:i, s:i, s:i}, s:o, s:o, s:o}",
                                      "api", 1, "program", cvol_version(), "threads", s->threads,
                                      "once", s->options->once, "limits", "size", VIEW_SIZE_MAX,
                                      "viewers", VIEWERS_MAX, "copies", COPIES_MAX, "transfers",
                                      transfers, "ct_transfers", ct, "film_formats", formats));
}

static answer volumes_get(request *r)
{
    return answer_json(200, volumes_describe(r->service->volumes));
}

static answer volume_get(request *r)
{
    shown_volume *v = volumes_hold(r->service->volumes, r->name);
    if (!v)
        return answer_error(404, "there is no volume '%s'", r->name);
    const answer a = answer_json(200, volume_describe(v));
    volume_release(v);
    return a;
}

static answer histogram_get(request *r)
{
    answer refusal;
    shown_volume *v = request_ready_volume(r, &refusal);
    if (!v)
        return refusal;
    json_t *bins = json_array();
    for (int i = 0; i < CVOL_HISTOGRAM_BINS; i++)
        json_array_append_new(bins, json_integer((json_int_t)v->histogram.bins[i]));
    const answer a = answer_json(200, json_pack("{s:f, s:f, s:o}", "min", v->histogram.min, "max",
                                                v->histogram.max, "bins", bins));
    volume_release(v);
    return a;
}

static answer status_get(request *r)
{
    json_t *object = jobs_describe(r->service->jobs);
    volumes *all = r->service->volumes;
    if (object) {
        json_object_set_new(object, "resident_bytes",
                            json_integer((json_int_t)volumes_resident_bytes(all)));
        json_object_set_new(object, "kept_bytes",
                            json_integer((json_int_t)volumes_kept_bytes(all)));
    }
    return answer_json(200, object);
}

/* The longest pause before a reloaded page sends requests again. */
#define END_WAIT_MAX_MS 60000
/* Requests of a closed page may arrive up to this time later. */
#define END_LATE_MS 100

static answer end_post(request *r)
{
    if (!r->service->options->once)
        return answer_error(403, "the viewer was started without --once, so a page cannot end it");
    int wait_ms = 0;
    char error[256] = "";
    if (r->body_bytes) {
        json_t *body;
        fields_parse(&body, r->body, r->body_bytes, error, sizeof error);
        fields f = {body, NULL, "", error, sizeof error};
        if (body) {
            take_integer(&f, "unless_asked_ms", &wait_ms, 0, END_WAIT_MAX_MS);
            fields_end(&f);
        }
        json_decref(body);
    }
    if (*error)
        return answer_error(400, "%s", error);
    if (wait_ms) {
        r->service->stay_ms = (int64_t)jobs_now() + END_LATE_MS;
        r->service->end_ms = (int64_t)jobs_now() + wait_ms;
    } else {
        r->service->end_requested = 1;
    }
    return answer_json(200, json_pack("{s:b}", "ending", 1));
}

static void stay(service *s)
{
    if (s->end_ms && (int64_t)jobs_now() >= s->stay_ms)
        s->end_ms = 0;
}

typedef struct route_entry {
    const char *method, *pattern; /* a star stands for one name */
    answer (*handle)(request *r);
} route_entry;

static const route_entry entries[] = {
    {"GET", "api/1", service_get},
    {"GET", "api/1/volumes", volumes_get},
    {"GET", "api/1/volumes/*", volume_get},
    {"GET", "api/1/volumes/*/histogram", histogram_get},
    {"DELETE", "api/1/volumes/*", volume_delete},
    {"GET", "api/1/volumes/*/transfer", transfer_get},
    {"POST", "api/1/volumes/*/transfer", transfer_post},
    {"GET", "api/1/volumes/*/slice", slice_get},
    {"GET", "api/1/volumes/*/value", value_get},
    {"POST", "api/1/volumes/*/copy", copy_post},
    {"POST", "api/1/frame", frame_post},
    {"POST", "api/1/pick", pick_post},
    {"POST", "api/1/difference", difference_post},
    {"POST", "api/1/command", command_post},
    {"POST", "api/1/films", film_post},
    {"GET", "api/1/films/*", film_get},
    {"DELETE", "api/1/films/*", film_delete},
    {"GET", "api/1/films/*/file", film_file_get},
    {"GET", "api/1/status", status_get},
    {"POST", "api/1/end", end_post},
};

/* 1 if the path matches; `name`: the part at the star. */
static int matches(const char *pattern, const char *path, char *name, size_t name_bytes)
{
    const char *star = strchr(pattern, '*');
    if (!star)
        return !strcmp(pattern, path);
    const size_t before = (size_t)(star - pattern);
    if (strncmp(pattern, path, before))
        return 0;
    const size_t length = strcspn(path + before, "/");
    if (!length || length >= name_bytes || strcmp(star + 1, path + before + length))
        return 0;
    snprintf(name, name_bytes, "%.*s", (int)length, path + before);
    return 1;
}

answer route(request *r)
{
    char allowed[32] = ""; /* GET, DELETE */
    if (strcmp(r->path, "api/1/end"))
        stay(r->service);
    for (size_t i = 0; i < sizeof entries / sizeof *entries; i++) {
        if (!matches(entries[i].pattern, r->path, r->name, sizeof r->name))
            continue;
        if (!strcmp(entries[i].method, r->method))
            return entries[i].handle(r);
        const size_t length = strlen(allowed);
        snprintf(allowed + length, sizeof allowed - length, "%s%s", length ? ", " : "",
                 entries[i].method);
    }
    const answer page = page_file(r->path);
    if (page.status && !strcmp(r->method, "GET"))
        return page;
    if (page.status)
        snprintf(allowed, sizeof allowed, "GET");
    if (allowed[0]) {
        answer a = answer_error(405, "%.100s accepts %s, not %.16s", r->path, allowed, r->method);
        answer_header(&a, "Allow", allowed);
        return a;
    }
    return answer_error(404, "unknown path '%.200s'", r->path);
}
