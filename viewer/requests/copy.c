/* Makes and removes coarser copies of volumes. */
#include "viewer/requests/copy.h"

#include <math.h>

#include "viewer/base/fields.h"

/* Upper limits of ratio and PSNR of a copy. */
static const double ratio_most = 1e6, psnr_most = 200;

/* Reads the target of the copy; 1 on success. */
static int take_options(cvol_compress_options *options, int *time, char *who, size_t who_bytes,
                        int times, fields *f)
{
    double ratio = 0, psnr = 0;
    const int by_ratio = take_number(f, "ratio", &ratio, 1, ratio_most);
    const int by_psnr = take_number(f, "psnr", &psnr, 0, psnr_most);
    take_integer(f, "time", time, 0, times - 1);
    take_text(f, "viewer", who, who_bytes);
    fields_end(f);
    if (by_ratio == by_psnr)
        fields_fail(f, "give ratio or psnr%s", by_ratio ? ", not both" : "");
    *options = cvol_compress_options_defaults();
    options->target = by_psnr ? CVOL_TARGET_PSNR : CVOL_TARGET_RATIO;
    options->target_value = by_psnr ? psnr : ratio;
    return fields_ok(f);
}

answer copy_post(request *r)
{
    answer refusal = {0};
    char error[512] = "", who[VIEWER_NAME_BYTES] = "";
    int time = 0;
    cvol_compress_options options;
    shown_volume *parent = request_ready_volume(r, &refusal);
    if (!parent)
        return refusal;
    if (parent->labels) {
        volume_release(parent);
        return answer_error(400, "volume '%s' has labels: a copy with loss would have other values",
                            r->name);
    }
    json_t *body;
    fields_parse(&body, r->body, r->body_bytes, error, sizeof error);
    fields f = {body, NULL, "", error, sizeof error};
    shown_volume *copy = NULL;
    if (body && take_options(&options, &time, who, sizeof who, parent->times, &f)) {
        copy = volumes_copy(r->service->volumes, parent, time, &options, who);
        refusal = copy ? answer_json(202, volume_describe(copy))
                       : answer_error(429, "there are already %d copies: remove one", COPIES_MAX);
    } else {
        refusal = answer_error(400, "%s", error);
    }
    json_decref(body);
    volume_release(copy);
    volume_release(parent);
    return refusal;
}

answer volume_delete(request *r)
{
    shown_volume *v = volumes_hold(r->service->volumes, r->name);
    if (!v)
        return answer_error(404, "there is no volume '%s'", r->name);
    const int failed = volumes_remove(r->service->volumes, v);
    volume_release(v);
    return failed
               ? answer_error(403, "volume '%s' is not a copy: only copies can be removed", r->name)
               : answer_json(200, json_pack("{s:s}", "removed", r->name));
}
