/* The table of requests, and the search for the handler of a path. */
#include "viewer/requests/routes.h"

#include <stdio.h>
#include <string.h>

#include "viewer/requests/command.h"
#include "viewer/requests/copy.h"
#include "viewer/requests/difference.h"
#include "viewer/requests/frame.h"
#include "viewer/requests/measure.h"
#include "viewer/requests/open.h"
#include "viewer/requests/pick.h"
#include "viewer/requests/slice.h"
#include "viewer/requests/transfer.h"
#include "viewer/service/request.h"

json_t *service_describe(const service *s)
{
    json_t *transfers = json_array(), *ct = json_array();
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
    return json_pack("{s:i, s:s, s:i, s:b, s:{s:i, s:i, s:i}, s:o, s:o, s:[]}", "api", 1, "program",
                     cvol_version(), "threads", s->threads, "once", s->options->once, "limits",
                     "size", VIEW_SIZE_MAX, "viewers", VIEWERS_MAX, "copies", COPIES_MAX,
                     "transfers", transfers, "ct_transfers", ct, "film_formats");
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

static const route_entry common_entries[] = {
    {"GET", "api/1/volumes", volumes_get},
    {"GET", "api/1/volumes/*", volume_get},
    {"GET", "api/1/volumes/*/histogram", histogram_get},
    {"DELETE", "api/1/volumes/*", volume_delete},
    {"GET", "api/1/volumes/*/transfer", transfer_get},
    {"POST", "api/1/volumes/*/transfer", transfer_post},
    {"GET", "api/1/volumes/*/slice", slice_get},
    {"GET", "api/1/volumes/*/value", value_get},
    {"POST", "api/1/volumes/*/copy", copy_post},
    {"POST", "api/1/volumes/*/open", open_post},
    {"POST", "api/1/volumes/*/measure", measure_post},
    {"POST", "api/1/frame", frame_post},
    {"POST", "api/1/pick", pick_post},
    {"POST", "api/1/difference", difference_post},
    {"POST", "api/1/command", command_post},
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

/* The number of entries of both lists. */
static size_t count_entries(const service *s)
{
    return sizeof common_entries / sizeof *common_entries + s->own_count;
}

static const route_entry *entry_at(const service *s, size_t i)
{
    const size_t common = sizeof common_entries / sizeof *common_entries;
    return i < common ? &common_entries[i] : &s->own[i - common];
}

answer route(request *r)
{
    char allowed[32] = ""; /* GET, DELETE */
    for (size_t i = 0; i < count_entries(r->service); i++) {
        const route_entry *entry = entry_at(r->service, i);
        if (!matches(entry->pattern, r->path, r->name, sizeof r->name))
            continue;
        if (!strcmp(entry->method, r->method))
            return entry->handle(r);
        const size_t length = strlen(allowed);
        snprintf(allowed + length, sizeof allowed - length, "%s%s", length ? ", " : "",
                 entry->method);
    }
    const answer page = r->service->page ? r->service->page(r->path) : (answer){0};
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
