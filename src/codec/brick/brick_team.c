/* Packets of bricks (brick_team.h). */
#include "codec/brick/brick_team.h"

#include <string.h>

#include "base/context.h"

/* In front of the bytes of a brick. */
typedef struct packed_brick {
    uint64_t brick;
    double error;
    uint64_t sizes[CVOL_SUBBANDS];
} packed_brick;

void cvol_share_bricks(size_t bricks[2], const cvol_share *share, const cvol_array *array)
{
    size_t grid[3];
    cvol_brick_grid(grid, array);
    const size_t in_layer = grid[0] * grid[1];
    for (int i = 0; i < 2; i++) {
        size_t layer = 0;
        while (layer < grid[2] &&
               cvol_brick_box_of(array, layer * in_layer).first[2] < share->layers[i])
            layer++;
        bricks[i] = layer * in_layer;
    }
}

void cvol_packet_put(cvol_bytes *packet, size_t brick, double error,
                     const cvol_span subbands[CVOL_SUBBANDS])
{
    packed_brick head = {.brick = brick, .error = error};
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        head.sizes[s] = subbands[s].size;
    cvol_bytes_append(packet, &head, sizeof head);
    for (int s = 0; s < CVOL_SUBBANDS; s++)
        cvol_bytes_append(packet, subbands[s].data, subbands[s].size);
}

int cvol_packet_open(cvol_context *context, const uint8_t *data, size_t size,
                     cvol_packet_brick *take, void *user)
{
    const uint8_t *end = data + size;
    int code = CVOL_OK;
    while (data < end && !code) {
        packed_brick head;
        cvol_span spans[CVOL_SUBBANDS];
        memcpy(&head, data, sizeof head);
        data += sizeof head;
        for (int s = 0; s < CVOL_SUBBANDS; s++) {
            spans[s] = (cvol_span){data, (size_t)head.sizes[s]};
            data += head.sizes[s];
        }
        code = take(context, user, (size_t)head.brick, head.error, spans);
    }
    return code;
}

int cvol_team_pass_bricks(cvol_context *context, cvol_team *team, int code, cvol_bytes *packet,
                          cvol_packet_brick *take, void *user)
{
    if (!code && packet->failed)
        code = cvol_fail_memory(context, packet->size, "the coded bricks");
    for (int rank = 0; rank < team->size; rank++) {
        const size_t own = rank == team->rank ? packet->size : 0;
        cvol_gathered all;
        code = cvol_team_gather(context, &all, team, code, packet->data, own);
        if (!code)
            code = cvol_packet_open(context, all.all, all.offsets[team->size], take, user);
        cvol_gathered_free(&all);
    }
    cvol_bytes_free(packet);
    return code;
}

int cvol_team_add_counts(cvol_context *context, cvol_team *team, int code,
                         cvol_token_counts *counts)
{
    cvol_gathered all;
    if (!team)
        return code;
    code = cvol_team_gather(context, &all, team, code, counts, sizeof *counts);
    if (!code)
        memset(counts, 0, sizeof *counts);
    for (int rank = 0; rank < team->size && !code; rank++) {
        cvol_token_counts one;
        memcpy(&one, all.all + all.offsets[rank], sizeof one);
        for (int r = 0; r < CVOL_ROWS; r++)
            for (int k = 0; k < CVOL_TOKENS; k++)
                counts->of[r][k] += one.of[r][k];
    }
    cvol_gathered_free(&all);
    return code;
}
