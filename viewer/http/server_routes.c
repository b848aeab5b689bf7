/* The requests that only the server of cvol view answers: films, its state, its end, and the page.
 */
#include "viewer/http/server_routes.h"

#include <string.h>

#include "viewer/films/film_out.h"
#include "viewer/films/films.h"
#include "viewer/http/page.h"
#include "viewer/requests/routes.h"
#include "viewer/volumes/times.h"
#include "viewer/volumes/volume_renderers.h"

static answer service_get(request *r)
{
    json_t *object = service_describe(r->service), *formats = json_array();
    const film_format *format;
    for (int i = 0; (format = film_format_at(i, r->service->options->movies)); i++)
        json_array_append_new(formats, json_string(format->name));
    json_object_set_new(object, "film_formats", formats);
    return answer_json(200, object);
}

static answer status_get(request *r)
{
    json_t *object = jobs_describe(r->service->jobs);
    volumes *all = r->service->volumes;
    uint64_t bytes;
    if (object) {
        json_object_set_new(object, "open_times",
                            json_integer(times_count(volumes_times(all), &bytes)));
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

static const route_entry entries[] = {
    {"GET", "api/1", service_get},
    {"POST", "api/1/films", film_post},
    {"GET", "api/1/films/*", film_get},
    {"DELETE", "api/1/films/*", film_delete},
    {"GET", "api/1/films/*/file", film_file_get},
    {"GET", "api/1/status", status_get},
    {"POST", "api/1/end", end_post},
};

void server_routes_set(service *s)
{
    s->own = entries;
    s->own_count = sizeof entries / sizeof *entries;
    s->page = page_file;
}

/* Requests after a page was closed keep the program running. */
static void stay(service *s)
{
    if (s->end_ms && (int64_t)jobs_now() >= s->stay_ms)
        s->end_ms = 0;
}

answer server_route(request *r)
{
    if (strcmp(r->path, "api/1/end"))
        stay(r->service);
    return route(r);
}
