/* The part of a request that all kinds of services share. */
#include "viewer/service/request.h"

shown_volume *request_ready_volume(const request *r, answer *refusal)
{
    shown_volume *v = volumes_hold(r->service->volumes, r->name);
    if (v && volume_is_ready(v))
        return v;
    char why[UNREADY_BYTES];
    if (v)
        volume_say_unready(why, sizeof why, v, r->name);
    *refusal = v ? answer_error(409, "%s", why)
                 : answer_error(404, "there is no volume '%s'", r->name);
    volume_release(v);
    return NULL;
}
