/* The viewer: a server that shows volumes in a browser. doc/viewer-api.md says what it answers.
 *
 * Only the cvol command starts it; it stands on the public headers alone.
 */
#ifndef CVOL_VIEWER_VIEWER_H
#define CVOL_VIEWER_VIEWER_H

#include "options.h"

typedef struct viewer viewer;

/* Starts listening, and to read the volumes. *out NULL: it could not, and `message` is the sentence
 * why. */
int viewer_open(viewer **out, char *message, size_t message_bytes, const viewer_options *options);
/* "http://127.0.0.1:40123/TOKEN/". */
const char *viewer_address(const viewer *v);
/* Now and then, some four times a second: closes connections that take too long. 1: the page has
 * asked to end. */
int viewer_tick(viewer *v);
/* Ends what runs, answers what waits, and frees it; NULL is allowed. */
void viewer_close(viewer *v);

#endif
