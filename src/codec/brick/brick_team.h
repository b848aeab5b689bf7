/* Bricks that the processes of a team exchange: each codes the bricks that begin in its share
 * (array/core/share.h), or others, and all get the bytes of all. */
#ifndef CVOL_CODEC_BRICK_BRICK_TEAM_H
#define CVOL_CODEC_BRICK_BRICK_TEAM_H

#include "array/core/share.h"
#include "base/bytes.h"
#include "base/team.h"
#include "codec/entropy/token_tables.h"
#include "codec/quantize/brick_box.h"

/* The bricks begin .. end - 1 of a share. */
void cvol_share_bricks(size_t bricks[2], const cvol_share *share, const cvol_array *array);

/* Appends a coded brick, with its squared error in steps, to a packet; memory may be short, as for
 * all functions of cvol_bytes. */
void cvol_packet_put(cvol_bytes *packet, size_t brick, double error,
                     const cvol_span subbands[CVOL_SUBBANDS]);
/* Receives a brick of a packet. */
typedef int cvol_packet_brick(cvol_context *context, void *user, size_t brick, double error,
                              const cvol_span subbands[CVOL_SUBBANDS]);
/* Passes on the bricks of packets in a row. Errors: those of `take`. */
int cvol_packet_open(cvol_context *context, const uint8_t *data, size_t size,
                     cvol_packet_brick *take, void *user);

/* Passes on the bricks of all processes, one process after the other, in all processes. Frees the
 * own packet. code: whether it is complete. Memory: the packet of another process. Errors: those of
 * cvol_team_gather and of `take`. */
int cvol_team_pass_bricks(cvol_context *context, cvol_team *team, int code, cvol_bytes *packet,
                          cvol_packet_brick *take, void *user);

/* Adds up the counts of all processes; NULL: nothing to do. Errors: those of cvol_team_gather. */
int cvol_team_add_counts(cvol_context *context, cvol_team *team, int code,
                         cvol_token_counts *counts);

#endif
