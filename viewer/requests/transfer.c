/* Transfer functions, fitted to a volume or from a file. */
#include "viewer/requests/transfer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "viewer/view/view.h"

json_t *transfer_describe(const cvol_transfer *transfer)
{
    json_t *points = json_array();
    for (size_t i = 0; i < cvol_transfer_count(transfer); i++) {
        const cvol_transfer_point p = cvol_transfer_point_at(transfer, i);
        json_array_append_new(points,
                              json_pack("[f, f, f, f, f]", p.value, p.r, p.g, p.b, p.opacity));
    }
    return json_pack("{s:o}", "points", points);
}

/* Answers with the transfer function, or with the message of the context; frees both. */
static answer answer_transfer(cvol_context *context, cvol_transfer *transfer, int code)
{
    const size_t count = transfer ? cvol_transfer_count(transfer) : 0;
    answer a;
    if (!context || code == CVOL_ERROR_MEMORY)
        a = answer_error(500, "not enough memory for a transfer function");
    else if (code)
        a = answer_error(400, "%s", cvol_context_message(context));
    else if (count > VIEW_POINTS_MAX)
        a = answer_error(400, "the transfer function has %zu points, must have at most %d", count,
                         VIEW_POINTS_MAX);
    else
        a = answer_exact_json(200, transfer_describe(transfer));
    cvol_transfer_free(transfer);
    cvol_context_free(context);
    return a;
}

/* The transfer function of an overlay, for samples of the spacing of the volume: ?overlay=0, with
 * the name and the window of the view. */
static answer overlay_transfer_get(request *r, shown_volume *v)
{
    const char *name = request_query(r, "name"), *window = request_query(r, "window"),
               *text = request_query(r, "overlay");
    const int i = text[0] >= '0' && text[0] <= '9' && !text[1] ? text[0] - '0' : -1;
    cvol_transfer *colours = NULL, *depths = NULL;
    char more;
    if (i < 0 || i >= overlays_owner(v)->overlay_count)
        return answer_error(400, "overlay is '%.40s': the volume has %d overlays", text,
                            overlays_owner(v)->overlay_count);
    const viewer_overlay *given = overlays_given(v, i);
    overlay_choice choice = overlays_first_choice(v, i);
    if (name && strlen(name) >= sizeof choice.transfer &&
        !(given->transfer && !strcmp(name, given->transfer)))
        return answer_error(400, "name is '%.40s', must be that of a transfer function", name);
    if (name && !(given->transfer && !strcmp(name, given->transfer)))
        snprintf(choice.transfer, sizeof choice.transfer, "%s", name);
    choice.has_window = window != NULL;
    if (window &&
        (sscanf(window, "%lf,%lf%c", &choice.window[0], &choice.window[1], &more) != 2 ||
         !(choice.window[0] < choice.window[1]) || !isfinite(choice.window[1] - choice.window[0])))
        return answer_error(400, "window is '%.60s', must be LO,HI: two rising numbers", window);
    cvol_context *context = cvol_context_create();
    const int code = context
                         ? overlays_create_transfers(context, &colours, &depths, v, i, &choice, 1)
                         : CVOL_ERROR_MEMORY;
    cvol_transfer_free(depths);
    return answer_transfer(context, colours, code);
}

answer transfer_get(request *r)
{
    answer refusal = {0};
    if (!request_knows(r, "name overlay window", &refusal))
        return refusal;
    if (request_query(r, "overlay")) {
        shown_volume *volume = request_ready_volume(r, &refusal);
        if (volume)
            refusal = overlay_transfer_get(r, volume);
        volume_release(volume);
        return refusal;
    }
    const char *name = request_query(r, "name");
    view v = {.opacity_scale = 1};
    if (!name || !*name || strlen(name) >= sizeof v.transfer_name)
        return answer_error(400, "name is '%.40s', must be one of %s %s", name ? name : "",
                            cvol_transfer_names(), cvol_transfer_ct_names());
    snprintf(v.transfer_name, sizeof v.transfer_name, "%s", name);
    v.volume = request_ready_volume(r, &refusal);
    if (!v.volume)
        return refusal;
    v.has_colour = !strcmp(name, VIEW_COMPONENT) && v.volume->channel.count;
    memcpy(v.colour, v.volume->channel.rgb, sizeof v.colour);
    cvol_context *context = cvol_context_create();
    cvol_transfer *transfer = NULL;
    uint64_t hash;
    const int code = context ? view_make_transfer(context, &transfer, &hash, &v)
                             : CVOL_ERROR_MEMORY;
    volume_release(v.volume);
    return answer_transfer(context, transfer, code);
}

answer transfer_post(request *r)
{
    answer refusal = {0};
    shown_volume *v = request_ready_volume(r, &refusal);
    if (!v)
        return refusal;
    const double rescale[2] = {v->grid.value_scale, v->grid.value_offset};
    volume_release(v);
    cvol_context *context = cvol_context_create();
    cvol_transfer *values = NULL, *transfer = NULL;
    int code = context ? cvol_transfer_parse(context, &values, r->body ? r->body : "",
                                             r->body ? r->body_bytes : 0, "the transfer function")
                       : CVOL_ERROR_MEMORY;
    if (!code) /* points of the view are of samples */
        code = cvol_transfer_create_rescaled(context, &transfer, values, rescale);
    cvol_transfer_free(values);
    return answer_transfer(context, transfer, code);
}
