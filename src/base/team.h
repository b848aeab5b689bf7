/* Processes that work on one task: all make the same calls in the same order, each does its share
 * of the work, and all get all results. A team has two processes or more; NULL: one works alone.
 *
 * Every exchange begins with an agreement on success. So a process that fails may leave the task,
 * if it then calls cvol_team_agree once: the others get its failure in their next exchange. */
#ifndef CVOL_BASE_TEAM_H
#define CVOL_BASE_TEAM_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/base.h"

typedef struct cvol_team {
    int rank, size;
    int has_failed; /* all processes know that one of them failed: nothing is shared any more */
    /* Gives every process the bytes of all: those of process r are offsets[r] .. offsets[r + 1] - 1
     * of *all, which the caller frees; offsets has size + 1 entries. code: CVOL_OK, or why this
     * process has none. If a process failed, all return its code, with its message. */
    int (*gather)(cvol_context *context, void *user, int code, uint8_t **all, size_t *offsets,
                  const void *own, size_t bytes);
    void *user;
} cvol_team;

/* 1 if this process does share number `share` of a task, from 0. */
static inline int cvol_team_does(const cvol_team *team, size_t share)
{
    return !team || share % (size_t)team->size == (size_t)team->rank;
}

/* 1 if this process writes files. */
static inline int cvol_team_writes(const cvol_team *team)
{
    return !team || team->rank == 0;
}

/* What a team has gathered; all zero is empty. */
typedef struct cvol_gathered {
    uint8_t *all;
    size_t *offsets;
} cvol_gathered;

/* Gathers; the caller frees *out, after a failure too. Errors: those of the first process that
 * failed; MEMORY. */
int cvol_team_gather(cvol_context *context, cvol_gathered *out, cvol_team *team, int code,
                     const void *own, size_t bytes);
void cvol_gathered_free(cvol_gathered *gathered);
/* Completes an array of which each process has consecutive items, begin .. end - 1, those of
 * process r + 1 behind those of process r. Errors: as above. */
int cvol_team_complete(cvol_context *context, cvol_team *team, int code, void *items, size_t size,
                       size_t begin, size_t end);
/* For a search of all processes for what is wrong, each at other places: returns the code of the
 * process that failed at the first place, and takes its message. `place` counts only if `code` is
 * not CVOL_OK. */
int cvol_team_first_failure(cvol_context *context, cvol_team *team, int code, size_t place);
/* Adds up a number of all processes. */
int cvol_team_add(cvol_context *context, cvol_team *team, int code, uint64_t *number);
/* Agrees on success without data. At the end of a task, it tells the others, who may wait for data,
 * that this process failed alone. */
int cvol_team_agree(cvol_context *context, cvol_team *team, int code);

#endif
