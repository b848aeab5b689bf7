/* Reads a time of a volume before it is shown: a page that plays a series asks for the next time
 * while it shows the last one. */
#include "viewer/requests/open.h"

#include <stdlib.h>

#include "viewer/volumes/times.h"

typedef struct opening {
    shown_volume *volume; /* held */
    int time;
} opening;

static answer run(job *j, cvol_context *context, void *state)
{
    const opening *o = state;
    shown_volume *at;
    const int code = times_hold(context, &at, o->volume, o->time);
    volume_release(at);
    return code ? jobs_failed(j, context, code)
                : answer_json(200, json_pack("{s:i}", "time", o->time));
}

static void free_opening(void *state)
{
    opening *o = state;
    volume_release(o->volume);
    free(o);
}

answer open_post(request *r)
{
    answer refusal = {0};
    char error[512] = "";
    shown_volume *volume = request_ready_volume(r, &refusal);
    if (!volume)
        return refusal;
    json_t *body;
    fields_parse(&body, r->body, r->body_bytes, error, sizeof error);
    fields f = {body, NULL, "", error, sizeof error};
    opening *o = calloc(1, sizeof *o);
    if (body && o) {
        if (!take_integer(&f, "time", &o->time, 0, volume->times - 1))
            fields_fail(&f, "time is missing: give the number of a time");
        fields_end(&f);
    }
    const int good = body && o && fields_ok(&f);
    json_decref(body);
    if (good) {
        o->volume = volume;
        return request_later(r, "", -1, 0, run, o, free_opening);
    }
    free(o);
    volume_release(volume);
    return answer_error(400, "%s", error[0] ? error : "not enough memory for a request");
}
