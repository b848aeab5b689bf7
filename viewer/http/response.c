/* Answers as responses of libmicrohttpd. */
#include "viewer/http/response.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Pages load nothing from other sites and cannot be framed; answers are not cached. */
static const char *const safety[][2] = {
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
     "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cache-Control", "no-store"},
};

/* ---- large answers ---------------------------------------------------------------------------
 */

enum { PART_BYTES = 64 << 10 };

/* Content that is sent in parts. */
typedef struct content {
    answer answer;
    void (*progress)(void *user, uint64_t sent);
    void *user;
} content;

static ssize_t read_part(void *user, uint64_t at, char *out, size_t most)
{
    content *c = user;
    const answer *a = &c->answer;
    const size_t left = a->size - (size_t)at, size = most < left ? most : left;
    ssize_t got = (ssize_t)size;
    c->progress(c->user, at);
    if (a->fd > 0)
        do
            got = pread(a->fd, out, size, (off_t)at);
        while (got < 0 && errno == EINTR);
    else
        memcpy(out, (const char *)a->bytes + at, size);
    return got > 0 ? got : MHD_CONTENT_READER_END_WITH_ERROR;
}

static void free_content(void *user)
{
    content *c = user;
    answer_free(&c->answer);
    free(c);
}

static struct MHD_Response *make_large(answer *a, void (*progress)(void *user, uint64_t sent),
                                       void *user)
{
    content *c = calloc(1, sizeof *c);
    struct MHD_Response *response = c ? MHD_create_response_from_callback(
                                            a->size, PART_BYTES, read_part, c, free_content)
                                      : NULL;
    if (!response) {
        free(c);
        return NULL;
    }
    *c = (content){
        {.bytes = a->bytes, .size = a->size, .release = a->release, .fd = a->fd}, progress, user};
    a->bytes = NULL;
    a->release = NULL;
    a->fd = 0;
    return response;
}

/* ---- all answers -----------------------------------------------------------------------------
 */

static struct MHD_Response *make_small(answer *a)
{
    struct MHD_Response *response;
    if (a->fd > 0) {
        response = MHD_create_response_from_fd64(a->size, a->fd);
        if (response)
            a->fd = 0;
        return response;
    }
    if (a->release)
        response = MHD_create_response_from_buffer_with_free_callback(a->size, a->bytes,
                                                                      a->release);
    else
        response = MHD_create_response_from_buffer(a->size, a->bytes, MHD_RESPMEM_PERSISTENT);
    if (response) {
        a->bytes = NULL;
        a->release = NULL;
    }
    return response;
}

struct MHD_Response *response_make(answer *a, uint64_t step,
                                   void (*progress)(void *user, uint64_t sent), void *user)
{
    struct MHD_Response *response = a->size > step ? make_large(a, progress, user) : make_small(a);
    if (!response)
        return NULL;
    MHD_add_response_header(response, "Content-Type", a->type);
    for (int i = 0; i < a->header_count; i++)
        MHD_add_response_header(response, a->header_names[i], a->headers[i]);
    for (size_t i = 0; i < sizeof safety / sizeof *safety; i++)
        MHD_add_response_header(response, safety[i][0], safety[i][1]);
    return response;
}
