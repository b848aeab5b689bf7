/* Teams (team.h). */
#include "base/team.h"

#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"

int cvol_team_gather(cvol_context *context, cvol_gathered *out, cvol_team *team, int code,
                     const void *own, size_t bytes)
{
    const size_t count = (size_t)team->size + 1;
    *out = (cvol_gathered){NULL, NULL};
    if (team->has_failed)
        return code;
    out->offsets = cvol_allocate_zero(count, sizeof(size_t));
    if (!code && !out->offsets)
        code = cvol_fail_memory(context, count * sizeof(size_t), "the results of processes");
    code = team->gather(context, team->user, code, &out->all, out->offsets, own, bytes);
    team->has_failed |= code != 0;
    return code;
}

void cvol_gathered_free(cvol_gathered *gathered)
{
    free(gathered->all);
    free(gathered->offsets);
    *gathered = (cvol_gathered){NULL, NULL};
}

int cvol_team_agree(cvol_context *context, cvol_team *team, int code)
{
    cvol_gathered none;
    if (!team)
        return code;
    code = cvol_team_gather(context, &none, team, code, NULL, 0);
    cvol_gathered_free(&none);
    return code;
}
