/* Connections. */
#include "viewer/http/server.h"

#include <errno.h>
#include <microhttpd.h>
#include <netdb.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>

#include "viewer/http/response.h"
#include "viewer/http/server_routes.h"

enum { IDLE_S = 20, THREADS = 2, CONNECTION_MEMORY = 64 << 10 };

static const server_limits usual_limits = {
    .unknown_ms = 4e3, .receiving_ms = 30e3, .sending_ms = 300e3, .step_bytes = 4 << 20};
/* A new unknown client closes the oldest. */
enum { UNKNOWN_CLIENTS_MAX = 32 };

/* An open connection. */
typedef struct client {
    int fd, answering, waiting; /* waiting: for a job */
    int known, closing;         /* known: it has sent the token */
    double since;
    uint64_t noted; /* bytes of the answer that were sent at `since` */
    struct client *next, **place;
} client;

struct server {
    struct MHD_Daemon *daemon;
    service *service;
    const access_rules *rules;
    pthread_mutex_t lock; /* of the rest */
    server_limits limits;
    client *clients;
};

/* A request on a connection, from its first header to the last byte of its answer. */
typedef struct exchange {
    server *server;
    struct MHD_Connection *connection;
    client *client;
    char *body;
    size_t body_bytes;
    int too_long;
    answer answer;
    request request;
} exchange;

/* ---- clients ----------------------------------------------------------------------------------
 */

static void set_client_state(server *s, client *c, int answering, int waiting)
{
    if (!c)
        return;
    pthread_mutex_lock(&s->lock);
    c->answering = answering;
    c->waiting = waiting;
    c->noted = 0;
    if (c->known) /* the time of an unknown client keeps running */
        c->since = jobs_now();
    pthread_mutex_unlock(&s->lock);
}

static void mark_known(server *s, client *c)
{
    if (!c)
        return;
    pthread_mutex_lock(&s->lock);
    c->known = 1;
    c->since = jobs_now();
    pthread_mutex_unlock(&s->lock);
}

static int is_known(server *s, client *c)
{
    pthread_mutex_lock(&s->lock);
    const int known = c && c->known;
    pthread_mutex_unlock(&s->lock);
    return known;
}

/* libmicrohttpd then closes the connection. Under the lock. */
static void end_client(client *c)
{
    c->closing = 1;
    shutdown(c->fd, SHUT_RDWR);
}

/* If there are too many unknown clients, closes the oldest, which is last in the list. Under the
 * lock. */
static void limit_unknown_clients(server *s)
{
    client *oldest = NULL;
    int count = 0;
    for (client *c = s->clients; c; c = c->next)
        if (!c->known && !c->closing) {
            oldest = c;
            count++;
        }
    if (count > UNKNOWN_CLIENTS_MAX)
        end_client(oldest);
}

static void on_connection(void *user, struct MHD_Connection *connection, void **context,
                          enum MHD_ConnectionNotificationCode code)
{
    server *s = user;
    if (code == MHD_CONNECTION_NOTIFY_STARTED) {
        const union MHD_ConnectionInfo *info = MHD_get_connection_info(
            connection, MHD_CONNECTION_INFO_CONNECTION_FD);
        client *c = calloc(1, sizeof *c);
        if (!c || !info) {
            free(c);
            return;
        }
        pthread_mutex_lock(&s->lock);
        *c = (client){
            .fd = info->connect_fd, .since = jobs_now(), .next = s->clients, .place = &s->clients};
        if (s->clients)
            s->clients->place = &c->next;
        s->clients = c;
        limit_unknown_clients(s);
        pthread_mutex_unlock(&s->lock);
        *context = c;
    } else if (*context) {
        client *c = *context;
        pthread_mutex_lock(&s->lock);
        *c->place = c->next;
        if (c->next)
            c->next->place = c->place;
        pthread_mutex_unlock(&s->lock);
        free(c);
        *context = NULL;
    }
}

void server_sweep(server *s)
{
    const double now = jobs_now();
    pthread_mutex_lock(&s->lock);
    for (client *c = s->clients; c; c = c->next)
        if (!c->closing && !c->waiting &&
            now - c->since > (!c->known      ? s->limits.unknown_ms
                              : c->answering ? s->limits.sending_ms
                                             : s->limits.receiving_ms))
            end_client(c);
    pthread_mutex_unlock(&s->lock);
}

/* ---- answers ----------------------------------------------------------------------------------
 */

/* Large answers take as long as they need, unless they are too slow. */
static void note_progress(void *user, uint64_t sent)
{
    exchange *e = user;
    server *s = e->server;
    client *c = e->client;
    if (!c)
        return;
    pthread_mutex_lock(&s->lock);
    if (c->known && sent >= c->noted + s->limits.step_bytes) {
        c->noted = sent;
        c->since = jobs_now();
    }
    pthread_mutex_unlock(&s->lock);
}

static enum MHD_Result give(exchange *e)
{
    answer *a = &e->answer;
    struct MHD_Response *response = response_make(a, e->server->limits.step_bytes, note_progress,
                                                  e);
    if (!response)
        return MHD_NO;
    if (!is_known(e->server, e->client))
        MHD_add_response_header(response, MHD_HTTP_HEADER_CONNECTION, "close");
    set_client_state(e->server, e->client, 1, 0);
    const enum MHD_Result result = MHD_queue_response(e->connection, (unsigned)a->status, response);
    MHD_destroy_response(response);
    answer_free(a);
    return result;
}

static void on_done(void *user, answer a)
{
    exchange *e = user;
    e->answer = a;
    MHD_resume_connection(e->connection);
}

answer request_later(request *r, const char *who, int64_t sequence, int large,
                     answer (*run)(job *j, cvol_context *context, void *state), void *state,
                     void (*free_state)(void *state))
{
    exchange *e = r->connection;
    job j = {.sequence = sequence,
             .large = large,
             .run = run,
             .state = state,
             .free_state = free_state,
             .done = on_done,
             .user = e};
    snprintf(j.viewer, sizeof j.viewer, "%s", who);
    set_client_state(e->server, e->client, 0, 1);
    MHD_suspend_connection(e->connection);
    jobs_add(r->service->jobs, &j);
    return (answer){0};
}

const char *request_query(const request *r, const char *name)
{
    const exchange *e = r->connection;
    return MHD_lookup_connection_value(e->connection, MHD_GET_ARGUMENT_KIND, name);
}

/* The search for an unknown parameter. */
typedef struct name_check {
    const char *known, *unknown;
} name_check;

static enum MHD_Result check_name(void *user, enum MHD_ValueKind kind, const char *name,
                                  const char *value)
{
    name_check *check = user;
    const size_t length = strlen(name);
    (void)kind;
    (void)value;
    for (const char *known = check->known; *known;) {
        const size_t size = strcspn(known, " ");
        if (size == length && !strncmp(known, name, size))
            return MHD_YES;
        known += size + strspn(known + size, " ");
    }
    check->unknown = name;
    return MHD_NO;
}

int request_knows(const request *r, const char *names, answer *refusal)
{
    const exchange *e = r->connection;
    name_check check = {names, NULL};
    MHD_get_connection_values(e->connection, MHD_GET_ARGUMENT_KIND, check_name, &check);
    if (check.unknown)
        *refusal = answer_error(400, "unknown parameter %.60s: give %s", check.unknown, names);
    return !check.unknown;
}

/* ---- requests ---------------------------------------------------------------------------------
 */

static const char *header(struct MHD_Connection *connection, const char *name)
{
    return MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
}

/* Counts a header: with several, other programs may read another one than this server. */
typedef struct header_count {
    const char *name;
    int count;
} header_count;

static enum MHD_Result count_header(void *user, enum MHD_ValueKind kind, const char *name,
                                    const char *value)
{
    header_count *c = user;
    (void)kind;
    (void)value;
    c->count += !strcasecmp(name, c->name);
    return MHD_YES;
}

static int is_repeated(struct MHD_Connection *connection, const char *name)
{
    header_count c = {name, 0};
    MHD_get_connection_values(connection, MHD_HEADER_KIND, count_header, &c);
    return c.count > 1;
}

/* Decodes %41 in URLs. A zero byte would hide the text after it: it becomes a character that no
 * name has. */
static size_t unescape(void *user, struct MHD_Connection *connection, char *text)
{
    const size_t length = MHD_http_unescape(text);
    (void)user;
    (void)connection;
    for (size_t i = 0; i < length; i++)
        if (!text[i])
            text[i] = 1;
    return length;
}

/* 1 if a browser navigates to the page, from the file that the command opens or from a link in a
 * message, which are other sites to it. The path must have the token; scripts and frames of other
 * pages do not count. */
static int is_navigation(const exchange *e, const char *path, const char *method)
{
    const char *mode = header(e->connection, "Sec-Fetch-Mode"),
               *to = header(e->connection, "Sec-Fetch-Dest");
    return !strcmp(method, MHD_HTTP_METHOD_GET) && strlen(path) == TOKEN_LETTERS + 2 && mode &&
           !strcmp(mode, "navigate") && to && !strcmp(to, "document");
}

/* Checks the headers of a new request. If it returns an answer, the body is not read. */
static answer begin(exchange *e, const char *path, const char *method)
{
    answer refusal = {0};
    const char *length = header(e->connection, MHD_HTTP_HEADER_CONTENT_LENGTH);
    const char *rest = access_rules_check(
        e->server->rules, &refusal, path, header(e->connection, MHD_HTTP_HEADER_HOST),
        header(e->connection, "Origin"),
        is_navigation(e, path, method) ? NULL : header(e->connection, "Sec-Fetch-Site"));
    if (!rest)
        return refusal;
    mark_known(e->server, e->client);
    if (is_repeated(e->connection, MHD_HTTP_HEADER_HOST) || is_repeated(e->connection, "Origin"))
        return answer_error(403, "the request has several headers Host or Origin");
    if (length && strtoull(length, NULL, 10) > BODY_MAX)
        return answer_error(413, "the body of the request has %.20s bytes, must have at most %d",
                            length, BODY_MAX);
    e->request = (request){
        .service = e->server->service, .path = rest, .method = method, .connection = e};
    return (answer){0};
}

/* Adds a part of the body. */
static void take_body(exchange *e, const char *data, size_t size)
{
    if (e->too_long || size > BODY_MAX - e->body_bytes) {
        e->too_long = 1;
        return;
    }
    char *body = realloc(e->body, e->body_bytes + size + 1);
    if (!body) {
        e->too_long = 1;
        return;
    }
    memcpy(body + e->body_bytes, data, size);
    e->body = body;
    e->body_bytes += size;
    body[e->body_bytes] = 0;
}

static enum MHD_Result on_request(void *user, struct MHD_Connection *connection, const char *path,
                                  const char *method, const char *version, const char *data,
                                  size_t *data_bytes, void **context)
{
    exchange *e = *context;
    (void)version;
    if (!e) {
        e = calloc(1, sizeof *e);
        if (!e)
            return MHD_NO;
        const union MHD_ConnectionInfo *info = MHD_get_connection_info(
            connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
        e->server = user;
        e->connection = connection;
        e->client = info ? info->socket_context : NULL;
        *context = e;
        e->answer = begin(e, path, method);
        return e->answer.status ? give(e) : MHD_YES;
    }
    if (*data_bytes) {
        take_body(e, data, *data_bytes);
        *data_bytes = 0;
        return MHD_YES;
    }
    if (e->answer.status) /* from a job */
        return give(e);
    if (e->too_long)
        e->answer = answer_error(413, "the body of the request has more than %d bytes", BODY_MAX);
    else {
        e->request.path = path + 1 + TOKEN_LETTERS + 1;
        e->request.method = method;
        e->request.body = e->body;
        e->request.body_bytes = e->body_bytes;
        const answer a = server_route(&e->request);
        if (!a.status) /* a job owns the request, and may have answered it */
            return MHD_YES;
        e->answer = a;
    }
    return give(e);
}

static void on_completed(void *user, struct MHD_Connection *connection, void **context,
                         enum MHD_RequestTerminationCode code)
{
    exchange *e = *context;
    (void)connection;
    (void)code;
    if (!e)
        return;
    set_client_state(user, e->client, 0, 0);
    answer_free(&e->answer);
    free(e->body);
    free(e);
    *context = NULL;
}

/* ---- beginning and end ------------------------------------------------------------------------
 */

static server *fail(server *s, char *message, size_t message_bytes, const char *listen, int port,
                    const char *why)
{
    snprintf(message, message_bytes, "cannot listen on %s, port %d: %s", listen, port, why);
    server_close(s);
    return NULL;
}

server *server_open(char *message, size_t message_bytes, service *served, const access_rules *rules)
{
    const char *listen = served->options->listen ? served->options->listen : "127.0.0.1";
    const int port = served->options->port;
    char port_text[16];
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_PASSIVE}, *address = NULL;
    server *s = calloc(1, sizeof *s);
    if (!s) {
        snprintf(message, message_bytes, "not enough memory");
        return NULL;
    }
    s->service = served;
    s->rules = rules;
    s->limits = usual_limits;
    pthread_mutex_init(&s->lock, NULL);
    snprintf(port_text, sizeof port_text, "%d", port);
    const int code = getaddrinfo(listen, port_text, &hints, &address);
    if (code)
        return fail(s, message, message_bytes, listen, port, gai_strerror(code));
    errno = 0;
    s->daemon = MHD_start_daemon(
        MHD_USE_AUTO_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME |
            (address->ai_family == AF_INET6 ? MHD_USE_IPv6 : 0),
        (uint16_t)port, NULL, NULL, on_request, s, MHD_OPTION_SOCK_ADDR, address->ai_addr,
        MHD_OPTION_CONNECTION_LIMIT, (unsigned)CONNECTIONS_MAX, MHD_OPTION_CONNECTION_TIMEOUT,
        (unsigned)IDLE_S, MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)CONNECTION_MEMORY,
        MHD_OPTION_THREAD_POOL_SIZE, (unsigned)THREADS, MHD_OPTION_NOTIFY_COMPLETED, on_completed,
        s, MHD_OPTION_NOTIFY_CONNECTION, on_connection, s, MHD_OPTION_UNESCAPE_CALLBACK, unescape,
        NULL, MHD_OPTION_END);
    freeaddrinfo(address);
    if (!s->daemon)
        return fail(s, message, message_bytes, listen, port,
                    errno ? strerror(errno) : "the system gives no reason");
    return s;
}

void server_set_limits(server *s, const server_limits *limits)
{
    pthread_mutex_lock(&s->lock);
    s->limits = *limits;
    pthread_mutex_unlock(&s->lock);
}

int server_port(const server *s)
{
    const union MHD_DaemonInfo *info = MHD_get_daemon_info(s->daemon, MHD_DAEMON_INFO_BIND_PORT);
    return info ? info->port : 0;
}

void server_close(server *s)
{
    if (!s)
        return;
    if (s->daemon)
        MHD_stop_daemon(s->daemon);
    pthread_mutex_destroy(&s->lock);
    free(s);
}
