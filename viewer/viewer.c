/* Starts and ends the parts of the viewer. */
#include "viewer/viewer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "viewer/films/films.h"
#include "viewer/http/server.h"
#include "viewer/http/server_routes.h"

struct viewer {
    viewer_options options;
    access_rules rules;
    service service;
    server *server;
    char *address;
};

static int fail(viewer *v, char *message, size_t message_bytes, const char *why)
{
    snprintf(message, message_bytes, "%s", why);
    viewer_close(v);
    return -1;
}

static char *make_address(const viewer *v)
{
    const char *listen = v->options.listen ? v->options.listen : "127.0.0.1";
    const int brackets = strchr(listen, ':') != NULL;
    const size_t bytes = strlen(listen) + TOKEN_LETTERS + 32;
    char *address = malloc(bytes);
    if (address)
        snprintf(address, bytes, "http://%s%s%s:%d/%s/", brackets ? "[" : "", listen,
                 brackets ? "]" : "", server_port(v->server), v->rules.token);
    return address;
}

int viewer_open(viewer **out, char *message, size_t message_bytes, const viewer_options *options)
{
    viewer *v = calloc(1, sizeof *v);
    *out = NULL;
    if (!v)
        return fail(v, message, message_bytes, "not enough memory");
    if (options->volume_count > VOLUMES_MAX) {
        char why[96];
        snprintf(why, sizeof why, "%d volumes are given, must be at most %d", options->volume_count,
                 VOLUMES_MAX);
        return fail(v, message, message_bytes, why);
    }
    v->options = *options;
    v->service.options = &v->options;
    server_routes_set(&v->service);
    if (access_rules_make(&v->rules, &v->options))
        return fail(v, message, message_bytes, "cannot make a token: /dev/urandom is not readable");
    cvol_context *context = cvol_context_create();
    if (context)
        cvol_context_set_threads(context, options->threads);
    v->service.threads = context ? cvol_context_threads(context) : 1;
    cvol_context_free(context);
    v->service.jobs = jobs_open(v->service.threads);
    if (!v->service.jobs)
        return fail(v, message, message_bytes, "not enough memory for threads");
    v->service.volumes = volumes_open(&v->options);
    if (!v->service.volumes)
        return fail(v, message, message_bytes, "not enough memory for the volumes");
    v->service.films = films_open(&v->options, v->service.threads);
    if (!v->service.films)
        return fail(v, message, message_bytes, "not enough memory");
    v->server = server_open(message, message_bytes, &v->service, &v->rules);
    if (!v->server) {
        viewer_close(v);
        return -1;
    }
    v->address = make_address(v);
    if (!v->address)
        return fail(v, message, message_bytes, "not enough memory");
    *out = v;
    return 0;
}

const char *viewer_address(const viewer *v)
{
    return v->address;
}

int viewer_tick(viewer *v)
{
    server_sweep(v->server);
    const int64_t end_ms = v->service.end_ms;
    return v->service.end_requested || (end_ms && jobs_now() >= (double)end_ms);
}

void viewer_close(viewer *v)
{
    if (!v)
        return;
    jobs_stop(v->service.jobs);
    server_close(v->server);
    jobs_free(v->service.jobs);
    films_close(v->service.films);
    volumes_close(v->service.volumes);
    free(v->address);
    free(v);
}
