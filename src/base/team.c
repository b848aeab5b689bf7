/* Teams (team.h). */
#include "base/team.h"

#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

int cvol_team_gather(cvol_context *context, cvol_gathered *out, cvol_team *team, int code,
                     const void *own, size_t bytes)
{
    const size_t count = (size_t)team->size + 1;
    *out = (cvol_gathered){NULL, NULL};
    if (team->has_failed)
        return code ? code : cvol_fail(context, CVOL_ERROR_CANCELLED, "another process failed");
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

int cvol_team_complete(cvol_context *context, cvol_team *team, int code, void *items, size_t size,
                       size_t begin, size_t end)
{
    cvol_gathered all;
    if (!team)
        return code;
    code = cvol_team_gather(context, &all, team, code, (const char *)items + size * begin,
                            size * (end - begin));
    if (!code)
        memcpy(items, all.all, all.offsets[team->size]);
    cvol_gathered_free(&all);
    return code;
}

typedef struct failure {
    uint64_t place;
    int code;
    char message[CVOL_MESSAGE_BYTES];
} failure;

int cvol_team_first_failure(cvol_context *context, cvol_team *team, int code, size_t place)
{
    failure own = {.place = place, .code = code}, first = {.code = CVOL_OK};
    cvol_gathered all;
    if (!team)
        return code;
    strcpy(own.message, context->message);
    code = cvol_team_gather(context, &all, team, CVOL_OK, &own, sizeof own);
    for (int rank = 0; rank < team->size && !code; rank++) {
        failure one;
        memcpy(&one, all.all + all.offsets[rank], sizeof one);
        if (one.code && (!first.code || one.place < first.place))
            first = one;
    }
    cvol_gathered_free(&all);
    return code || !first.code ? code : cvol_fail(context, first.code, "%s", first.message);
}

int cvol_team_add(cvol_context *context, cvol_team *team, int code, uint64_t *number)
{
    cvol_gathered all;
    if (!team)
        return code;
    code = cvol_team_gather(context, &all, team, code, number, sizeof *number);
    *number = 0;
    for (int rank = 0; rank < team->size && !code; rank++) {
        uint64_t one;
        memcpy(&one, all.all + all.offsets[rank], sizeof one);
        *number += one;
    }
    cvol_gathered_free(&all);
    return code;
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
