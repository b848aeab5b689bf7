/* Frames: what a viewer asks for most. */
#ifndef CVOL_VIEWER_FRAME_H
#define CVOL_VIEWER_FRAME_H

#include "request.h"
#include "view.h"

/* What frames and what is like them are asked for beside a view. */
typedef struct frame_request {
    view view;
    int motion, quality; /* of JPEG; 0: PNG */
    double budget_ms;
    char viewer[VIEWER_NAME_BYTES];
    int64_t sequence;
} frame_request;

/* What a frame was, for its headers. */
typedef struct frame_figures {
    int rung, level; /* level: coarser than the rung's where the file ends early */
    double render_ms, encode_ms;
} frame_figures;

/* Takes the fields that frames have. 0, or the status of HTTP whose sentence f->error then is. */
int frame_take(frame_request *out, volumes *all, fields *f);
/* Whether it is so large that others should not have to wait for it. */
int frame_is_large(const frame_request *asked);
/* Draws it, mirrored if the view is, within the budget in motion; the caller frees *out. */
int frame_draw(cvol_context *context, cvol_image **out, frame_figures *figures,
               const frame_request *asked, pace *times);
/* Encodes it; `more` (may be NULL; taken) joins the JSON of the header Cvol-Frame. */
answer frame_answer(cvol_context *context, const job *j, const cvol_image *image,
                    frame_figures *figures, const frame_request *asked, json_t *more);

/* POST api/1/frame */
answer frame_post(request *r);

#endif
