/* The viewer: a server that shows volumes in a browser. doc/viewer-api.md describes its interface.
 *
 * Only the cvol command starts it. It uses only public headers.
 */
#ifndef CVOL_VIEWER_VIEWER_H
#define CVOL_VIEWER_VIEWER_H

#include "viewer/base/options.h"

typedef struct viewer viewer;

/* Starts to listen and to read the volumes. 0, or -1 with the reason in `message`; *out is then
 * NULL. */
int viewer_open(viewer **out, char *message, size_t message_bytes, const viewer_options *options);
/* "http://127.0.0.1:40123/TOKEN/". */
const char *viewer_address(const viewer *v);
/* Call it about four times a second: closes connections that take too long. 1: the page asked to
 * end. */
int viewer_tick(viewer *v);
/* Cancels running jobs, answers waiting ones, and frees the viewer; NULL is allowed. */
void viewer_close(viewer *v);

#endif
