/* The overlays of cvol view. */
#ifndef CVOL_TOOLS_VIEW_OVERLAYS_H
#define CVOL_TOOLS_VIEW_OVERLAYS_H

#include "tools/render/overlay_options.h"
#include "tools/view/view_list.h"

typedef struct view_overlays {
    int count;
    viewer_overlay shown[OVERLAYS_MAX];
    overlay_source sources[OVERLAYS_MAX];
    label_set *sets[OVERLAYS_MAX];      /* of labels; NULL: none */
    viewer_label *labels[OVERLAYS_MAX]; /* their facts for the viewer */
    cvol_transfer *files[OVERLAYS_MAX]; /* transfer functions of files; NULL: none */
} view_overlays;

/* Reads the overlays, and checks that each can be drawn over all volumes. The caller closes them,
 * after an error too. Exit status. */
int open_view_overlays(cvol_context *context, view_overlays *out, const overlay_options *o,
                       const view_list *list, int threads);
void close_view_overlays(view_overlays *overlays);

#endif
