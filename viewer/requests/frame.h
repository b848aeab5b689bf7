/* Frames: pictures of a view, in motion or still. */
#ifndef CVOL_VIEWER_REQUESTS_FRAME_H
#define CVOL_VIEWER_REQUESTS_FRAME_H

#include "viewer/service/request.h"
#include "viewer/view/view.h"

/* The fields of a frame request. */
typedef struct frame_request {
    view view;
    int motion, quality; /* of JPEG; 0: PNG */
    int rung;            /* the quality that was asked for by name; not in motion */
    double budget_ms;
    char viewer[VIEWER_NAME_BYTES];
    int64_t sequence;
} frame_request;

/* Results of a frame, for its headers. */
typedef struct frame_figures {
    int rung, level; /* level: may be coarser than that of the rung if the file ends early */
    double render_ms, encode_ms;
    int is_empty; /* every pixel is background */
} frame_figures;

/* Reads the fields of a frame. 0, or a status of HTTP, with the message in f->error. */
int frame_take(frame_request *out, volumes *all, fields *f);
/* 1 if the frame is so large that it must run in the background. */
int frame_is_large(const frame_request *frame);
/* Draws the frame, mirrored if the view is; in motion within the budget. The caller frees *out. */
int frame_draw(cvol_context *context, cvol_image **out, frame_figures *figures,
               const frame_request *frame, pace *times);
/* Encodes the frame; adds `more` (or NULL; freed) to the JSON of the header Cvol-Frame. */
answer frame_answer(cvol_context *context, const job *j, const cvol_image *image,
                    frame_figures *figures, const frame_request *frame, json_t *more);

/* POST api/1/frame */
answer frame_post(request *r);

#endif
