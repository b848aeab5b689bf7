/* Answers as responses of libmicrohttpd. */
#ifndef CVOL_VIEWER_HTTP_RESPONSE_H
#define CVOL_VIEWER_HTTP_RESPONSE_H

#include <microhttpd.h>

#include "viewer/base/answer.h"

/* A response with the content of an answer, which no longer has it, and its headers; NULL: no
 * memory. progress(user, sent) is called while the content is sent, with the number of bytes so
 * far, if there are more than `step`. */
struct MHD_Response *response_make(answer *a, uint64_t step,
                                   void (*progress)(void *user, uint64_t sent), void *user);

#endif
