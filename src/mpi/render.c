/* Pictures by several processes (cvol/mpi.h): every process draws its part into the intermediate
 * image of the whole view, and these are put together (exchange.h). (Molnar, Cox,
 * Ellsworth and Fuchs, "A sorting classification of parallel rendering", 1994: sort-last.) */
#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "mpi/exchange.h"
#include "mpi/parts.h"
#include "render/view/camera.h"
#include "render/view/options.h"

/* Samples by which parts overlap. */
#define OVERLAP 2

/* Puts the ranks of a node's leaves into order[*count] and after it, from front to back. */
static void order_parts(const cvol_mpi_parts *parts, int node, const cvol_view *view, int *order,
                        int *count)
{
    const cvol_mpi_node *n = &parts->nodes[node];
    if (n->axis < 0) {
        order[(*count)++] = n->below;
        return;
    }
    const double at = n->at * parts->grid.spacing[n->axis];
    const int from_above = view->perspective ? view->place[n->axis] > at : view->eye[n->axis] > 0;
    order_parts(parts, from_above ? n->above : n->below, view, order, count);
    order_parts(parts, from_above ? n->below : n->above, view, order, count);
}

/* 1 if the clip leaves something of the part. */
static int is_drawn(const cvol_part *part, const cvol_clip *clip, const cvol_grid *grid)
{
    for (int a = 0; a < 3; a++) {
        const double margin = grid->dims[a] > 1 ? 0 : 0.5;
        double from = fmax(part->from[a], -margin),
               to = fmin(part->to[a], (double)(grid->dims[a] - 1) + margin);
        if (clip->axes >> a & 1) {
            from = fmax(from, clip->from[a]);
            to = fmin(to, clip->to[a]);
        }
        if (!(from < to))
            return 0;
    }
    return 1;
}

/* The largest and the smallest sample may belong to two parts: then no interval of a ray is cut
 * without being whole in one of them. */
static cvol_part drawn_part(const cvol_mpi_parts *parts, cvol_mode mode)
{
    cvol_part part = parts->boxes[parts->rank];
    for (int a = 0; a < 3 && (mode == CVOL_MODE_MIP || mode == CVOL_MODE_MIN); a++) {
        part.from[a] -= OVERLAP;
        part.to[a] += OVERLAP;
    }
    return part;
}

static int draw_part(cvol_context *context, cvol_renderer *renderer, cvol_image *image,
                     const cvol_render_options *options, const cvol_part *part,
                     const cvol_mpi_exchange *exchange)
{
    cvol_render_options own = *options;
    own.part = exchange->combine.is_idle ? (cvol_part){.axes = 0} : *part;
    int code = cvol_renderer_set_combine(context, renderer, &exchange->combine);
    if (code)
        return code;
    code = cvol_renderer_render(context, renderer, image, &own);
    const int unset = cvol_renderer_set_combine(context, renderer, NULL);
    return code ? code : unset;
}

static int check(cvol_context *context, cvol_renderer *renderer, const cvol_image *image)
{
    const int code = cvol_renderer_set_combine(context, renderer, NULL);
    if (code)
        return code;
    if (!image->values || image->depth)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "several processes draw pictures of floats, without depths");
    return CVOL_OK;
}

int cvol_mpi_render(cvol_context *context, cvol_mpi_render_report *report, cvol_mpi_parts *parts,
                    cvol_renderer *renderer, cvol_image *image, const cvol_render_options *options)
{
    int *order = cvol_allocate((size_t)parts->size, sizeof *order), count = 0, rank;
    cvol_render_options full;
    cvol_view view;
    int code = order ? cvol_render_options_complete(context, &full, options)
                     : cvol_fail_memory(context, (size_t)parts->size * sizeof *order, "parts");
    if (!code)
        code = check(context, renderer, image);
    if (!code)
        code = cvol_view_make(context, &view, &parts->grid, &full);
    if (!(code = cvol_mpi_agree(context, code, &rank, parts->comm))) {
        const cvol_part part = drawn_part(parts, full.mode);
        cvol_mpi_exchange exchange;
        order_parts(parts, 0, &view, order, &count);
        cvol_mpi_exchange_begin(&exchange, parts, order,
                                !is_drawn(&part, &full.clip, &parts->grid));
        code = draw_part(context, renderer, image, &full, &part, &exchange);
        cvol_mpi_exchange_end(&exchange);
        if (!exchange.has_failed)
            code = cvol_mpi_agree(context, code, &rank, parts->comm);
        if (!code && report)
            cvol_mpi_exchange_report(report, &exchange);
    }
    free(order);
    return code;
}
