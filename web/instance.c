/* The functions that JavaScript calls. An instance holds the volumes of files in the memory file
 * system, and answers the requests of doc/viewer-api.md, one after the other. */
#include <emscripten.h>
#include <emscripten/heap.h>
#include <string.h>

#include "no_threads.h"
#include "viewer/requests/routes.h"
#include "volume_list.h"

enum { TIMES_MB = 100 }; /* each worker keeps so much of the times that it read */

static struct {
    viewer_options options;
    volume_list list;
    service service;
    answer answer; /* the last one */
} instance;

static answer service_get(request *r)
{
    json_t *object = service_describe(r->service);
    json_object_set_new(json_object_get(object, "limits"), "copies", json_integer(0));
    return answer_json(200, object);
}

static const route_entry entries[] = {{"GET", "api/1", service_get}};

/* Adds the volumes of a file: the name to show, the time and the channel, or -1 for all of them,
 * and the level to read. 0, or -1 without memory. */
EMSCRIPTEN_KEEPALIVE int web_add(const char *path, const char *name, int time, int channel,
                                 int level)
{
    return volume_list_add(&instance.list, path, name, time, channel, level);
}

/* Sets the levels of bricks of the last file: volume_list_set_bricks. */
EMSCRIPTEN_KEEPALIVE void web_set_bricks(uint8_t *levels, size_t count)
{
    volume_list_set_bricks(&instance.list, levels, count);
}

/* Adds a label to the volumes of the last file: volume_list_add_label. */
EMSCRIPTEN_KEEPALIVE int web_add_label(int value, const char *name, double r, double g, double b)
{
    return volume_list_add_label(&instance.list, value, name, (const double[]){r, g, b});
}

/* Reads the added volumes. keep_mb: size of the block caches of all of them. 0, or -1 without
 * memory. */
EMSCRIPTEN_KEEPALIVE int web_open(double keep_mb)
{
    service *s = &instance.service;
    instance.options.volumes = instance.list.volumes;
    instance.options.volume_count = instance.list.count;
    instance.options.keep_mb = keep_mb;
    instance.options.times_mb = TIMES_MB;
    instance.options.threads = 1;
    instance.options.is_cold = 1;
    *s = (service){.options = &instance.options,
                   .own = entries,
                   .own_count = sizeof entries / sizeof *entries,
                   .threads = 1};
    s->volumes = volumes_open(&instance.options);
    return s->volumes ? 0 : -1;
}

/* ---- copies of instances ----------------------------------------------------------------------
 * An instance between two calls is the bytes of its memory: its stack is empty. */

/* The number of bytes in use, from address 0. */
EMSCRIPTEN_KEEPALIVE size_t web_memory_used(void)
{
    return *emscripten_get_sbrk_ptr();
}

/* Makes the memory that large; 0: not possible. */
EMSCRIPTEN_KEEPALIVE int web_memory_grow(size_t bytes)
{
    return bytes <= emscripten_get_heap_size() || emscripten_resize_heap(bytes);
}

/* ---- requests ---------------------------------------------------------------------------------
 */

/* Answers a request; the answer stays until the next one. The query as in web_call. Returns the
 * status of HTTP. */
EMSCRIPTEN_KEEPALIVE int web_request(const char *method, const char *path, const char *query,
                                     const char *body, size_t body_bytes)
{
    web_call call = {query};
    request r = {.service = &instance.service,
                 .method = method,
                 .path = path,
                 .body = body,
                 .body_bytes = body_bytes,
                 .connection = &call};
    answer_free(&instance.answer);
    instance.answer = route(&r);
    return instance.answer.status;
}

EMSCRIPTEN_KEEPALIVE const void *web_answer_bytes(void)
{
    return instance.answer.bytes;
}

EMSCRIPTEN_KEEPALIVE size_t web_answer_size(void)
{
    return instance.answer.size;
}

EMSCRIPTEN_KEEPALIVE const char *web_answer_type(void)
{
    return instance.answer.type;
}

/* The value of a header; "": the answer does not have it. */
EMSCRIPTEN_KEEPALIVE const char *web_answer_header(const char *name)
{
    const answer *a = &instance.answer;
    for (int i = 0; i < a->header_count; i++)
        if (!strcmp(a->header_names[i], name))
            return a->headers[i];
    return "";
}
