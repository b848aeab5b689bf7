/* The options --overlay of cvol render and cvol view, and the volumes that they name. */
#ifndef CVOL_TOOLS_OVERLAY_OPTIONS_H
#define CVOL_TOOLS_OVERLAY_OPTIONS_H

#include "tools/base/cli.h"
#include "tools/labels/labels.h"
#include "tools/overlay/overlay.h"

typedef struct overlay_options {
    text_list files; /* the others have one value for each */
    texts_of transfers, windows, opacities, depths, labels, tables;
} overlay_options;

#define OVERLAY_OPTIONS(o)                                                                       \
    {"--overlay",                                                                                \
     "FILE",                                                                                     \
     "draw a second volume over the first, as PET over MRI or labels (up to 4 times)",           \
     OPTION_TEXTS,                                                                               \
     &(o).files,                                                                                 \
     OVERLAYS_MAX,                                                                               \
     NULL},                                                                                      \
        {"--overlay-transfer",                                                                   \
         "NAME|FILE",                                                                            \
         "transfer function of the overlay before it (default: hot; labels: a colour for each)", \
         OPTION_OF_LAST,                                                                         \
         &(o).transfers,                                                                         \
         0,                                                                                      \
         NULL},                                                                                  \
        {"--overlay-window",                                                                     \
         "C,W",                                                                                  \
         "values of the overlay over which its colours are spread",                              \
         OPTION_OF_LAST,                                                                         \
         &(o).windows,                                                                           \
         0,                                                                                      \
         NULL},                                                                                  \
        {"--overlay-opacity",                                                                    \
         "O",                                                                                    \
         "opacity of the overlay, 0 to 1 (default 1)",                                           \
         OPTION_OF_LAST,                                                                         \
         &(o).opacities,                                                                         \
         0,                                                                                      \
         NULL},                                                                                  \
        {"--overlay-depth",                                                                      \
         "D",                                                                                    \
         "how deep behind the visible surface it shines through (default: a quarter of the "     \
         "diagonal)",                                                                            \
         OPTION_OF_LAST,                                                                         \
         &(o).depths,                                                                            \
         0,                                                                                      \
         NULL},                                                                                  \
        {"--overlay-labels",                                                                     \
         "LIST",                                                                                 \
         "of an overlay of labels draw only these, as --labels",                                 \
         OPTION_OF_LAST,                                                                         \
         &(o).labels,                                                                            \
         0,                                                                                      \
         NULL},                                                                                  \
    {                                                                                            \
        "--overlay-label-table", "FILE", "names and colours of these labels, as --label-table",  \
            OPTION_OF_LAST, &(o).tables, 0, NULL                                                 \
    }

/* Ties the options to --overlay. */
void begin_overlay_options(overlay_options *o);
/* Exit status. */
int check_overlay_values(const overlay_options *o);
/* Reads overlay i; the caller frees source->samples and *labels, after an error too. Exit status.
 */
int read_overlay(cvol_context *context, overlay_source *source, label_set **labels,
                 const overlay_options *o, int i, int threads);
/* The look of overlay i; the caller frees *file, the transfer function of a file, which the look
 * refers to. Exit status. */
int choose_overlay_look(cvol_context *context, overlay_look *look, cvol_transfer **file,
                        const overlay_source *source, const overlay_options *o, int i);
/* Says that nothing of an overlay with one value is drawn. */
void warn_of_blank_overlay(const overlay_source *source, const overlay_look *look);

#endif
