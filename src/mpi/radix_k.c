/* Radix-k compositing: radix_k.h. */
#include "mpi/radix_k.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"

/* Tags of messages: a round has its number. */
enum { TAG_FOLD = CVOL_MPI_MOST_ROUNDS, TAG_GATHER };

/* ---- members ------------------------------------------------------------------------------- */

/* Divides by the largest possible factors; 0: `members` has a prime factor that is too large. */
static int find_factors(cvol_mpi_rounds *rounds, int members)
{
    *rounds = (cvol_mpi_rounds){.members = members};
    while (members > 1) {
        int k = CVOL_MPI_MOST_K;
        while (k > 1 && members % k)
            k--;
        if (k == 1)
            return 0;
        rounds->factors[rounds->count++] = k;
        members /= k;
    }
    return 1;
}

cvol_mpi_rounds cvol_mpi_rounds_of(int processes)
{
    cvol_mpi_rounds rounds;
    while (!find_factors(&rounds, processes))
        processes--;
    return rounds;
}

/* The first processes in the order are folded: of each two, the second gives its fragment to the
 * first. */
static int folded_pairs(const cvol_mpi_radix_k *r)
{
    return r->parts->size - r->rounds.members;
}

static int member_at(const cvol_mpi_radix_k *r, int place)
{
    const int pairs = folded_pairs(r);
    if (place >= 2 * pairs)
        return place - pairs;
    return place % 2 ? -1 : place / 2;
}

static int rank_of(const cvol_mpi_radix_k *r, int member)
{
    const int pairs = folded_pairs(r);
    return r->order[member < pairs ? 2 * member : member + pairs];
}

/* ---- pieces -------------------------------------------------------------------------------- */

/* Counts the pixels that show something: of this process, and by group of all processes. */
static void count_shown(cvol_mpi_radix_k *r, size_t *pixels, size_t *runs)
{
    const size_t groups = r->lines->groups;
    *pixels = *runs = 0;
    for (size_t g = 0; g < groups; g++) {
        r->spans[g] = cvol_mpi_span_of(r->lines, g, &r->blend);
        r->shown[g] = r->spans[g].pixels;
        *pixels += r->spans[g].pixels;
        *runs += r->spans[g].runs;
    }
    MPI_Allreduce(MPI_IN_PLACE, r->shown, (int)groups, MPI_UINT64_T, MPI_SUM, r->parts->comm);
}

/* Within a group, the pixels that show something count as evenly spread. */
static void find_bounds(cvol_mpi_radix_k *r)
{
    const size_t groups = r->lines->groups, n = r->lines->count;
    const int members = r->rounds.members;
    double all = 0, before = 0;
    size_t g = 0;
    for (size_t i = 0; i < groups; i++)
        all += (double)r->shown[i];
    r->bounds[0] = 0;
    for (int i = 1; i < members; i++) {
        const double wanted = all * i / members;
        while (g < groups && before + (double)r->shown[g] <= wanted)
            before += (double)r->shown[g++];
        const double share = g < groups ? (wanted - before) / (double)r->shown[g] : 0;
        r->bounds[i] = g * n + (size_t)(share * (double)n);
    }
    r->bounds[members] = groups * n;
}

static size_t pixels_of(const cvol_mpi_radix_k *r, const int piece[2])
{
    return r->bounds[piece[1]] - r->bounds[piece[0]];
}

/* One of the k parts of some pieces. */
static void choose_part(int piece[2], int k, int part)
{
    const int count = (piece[1] - piece[0]) / k;
    piece[0] += part * count;
    piece[1] = piece[0] + count;
}

/* ---- memory -------------------------------------------------------------------------------- */

typedef struct room {
    size_t runs, pixels;   /* of a fragment */
    size_t sent, received; /* cells of messages */
} room;

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

/* Room for a fragment of up to `pixels` pixels in a row that has been merged from up to k messages,
 * and for the messages into which a next round cuts it: each cut adds a run and a header. */
static void add_room(room *most, size_t runs, size_t pixels, int k, const cvol_mpi_blend *blend)
{
    most->runs = larger(most->runs, runs);
    most->pixels = larger(most->pixels, pixels);
    most->sent = larger(most->sent,
                        cvol_mpi_message_cells(runs, pixels, blend) + 2 * CVOL_MPI_MOST_K);
    if (k > 1)
        most->received = larger(most->received,
                                (size_t)(k - 1) * cvol_mpi_message_most(pixels, blend));
}

/* Memory that is not used is not touched. */
static room find_room(const cvol_mpi_radix_k *r, size_t own_runs, size_t own_pixels)
{
    room most = {.received = 1};
    int piece[2] = {0, r->rounds.members}, stride = 1;
    const size_t all = pixels_of(r, piece);
    add_room(&most, own_runs, own_pixels, 1, &r->blend);
    if (r->member >= 0 && r->member < folded_pairs(r))
        add_room(&most, (all + 1) / 2, all, 2, &r->blend);
    for (int i = 0; i < r->rounds.count && r->member >= 0; i++) {
        const int k = r->rounds.factors[i];
        choose_part(piece, k, r->member / stride % k);
        add_room(&most, (pixels_of(r, piece) + 1) / 2, pixels_of(r, piece), k, &r->blend);
        stride *= k;
    }
    for (int i = 0; i < r->rounds.members && r->place == r->root; i++)
        most.received = larger(most.received,
                               cvol_mpi_message_most(r->bounds[i + 1] - r->bounds[i], &r->blend));
    return most;
}

int cvol_mpi_radix_k_begin(cvol_context *context, cvol_mpi_radix_k *r, cvol_mpi_parts *parts,
                           const int *order, const cvol_sheet_lines *lines, cvol_mode mode)
{
    *r = (cvol_mpi_radix_k){.parts = parts,
                            .order = order,
                            .rounds = cvol_mpi_rounds_of(parts->size),
                            .blend = cvol_mpi_blend_of(mode),
                            .lines = lines};
    while (order[r->place] != parts->rank)
        r->place++;
    while (order[r->root])
        r->root++;
    r->member = member_at(r, r->place);
    r->piece[1] = r->rounds.members;
    if (cvol_mpi_message_most(lines->groups * lines->count, &r->blend) > INT_MAX)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "several processes draw intermediate images of up to %d pixels, not %zu",
                         INT_MAX / 5 * 2, lines->groups * lines->count);
    r->spans = cvol_allocate(lines->groups, sizeof *r->spans);
    r->shown = cvol_allocate(lines->groups, sizeof *r->shown);
    r->bounds = cvol_allocate((size_t)r->rounds.members + 1, sizeof *r->bounds);
    if (!r->spans || !r->shown || !r->bounds)
        return cvol_fail_memory(context, lines->groups * sizeof *r->spans, "a picture of parts");
    return CVOL_OK;
}

/* Memory without content. NULL: there is not enough. */
static void *get_memory(cvol_mpi_memory *memory, size_t count, size_t size)
{
    size_t bytes;
    if (!cvol_size_multiply(&bytes, count, size))
        return NULL;
    if (memory->bytes && memory->size >= bytes)
        return memory->bytes;
    free(memory->bytes);
    *memory = (cvol_mpi_memory){cvol_allocate(bytes, 1), bytes};
    return memory->bytes;
}

int cvol_mpi_radix_k_divide(cvol_context *context, cvol_mpi_radix_k *r)
{
    size_t runs, pixels;
    count_shown(r, &pixels, &runs);
    find_bounds(r);
    const room most = find_room(r, runs, pixels);
    r->fragment.runs = get_memory(&r->parts->memory.runs, most.runs, sizeof *r->fragment.runs);
    r->fragment.values = get_memory(&r->parts->memory.values, most.pixels,
                                    r->blend.depth * sizeof *r->fragment.values);
    r->sent = get_memory(&r->parts->memory.sent, most.sent, sizeof *r->sent);
    r->received = get_memory(&r->parts->memory.received, most.received, sizeof *r->received);
    if (!r->fragment.runs || !r->fragment.values || !r->sent || !r->received)
        return cvol_fail_memory(context, (most.sent + most.received) * sizeof *r->sent,
                                "a picture of parts");
    return CVOL_OK;
}

void cvol_mpi_radix_k_end(cvol_mpi_radix_k *r)
{
    free(r->spans);
    free(r->shown);
    free(r->bounds);
}

/* ---- rounds -------------------------------------------------------------------------------- */

static void count(cvol_mpi_radix_k *r, size_t cells)
{
    r->traffic.messages++;
    r->traffic.bytes += cells * sizeof *r->sent;
}

/* The whole fragment as a message in r->sent. Returns its cells. */
static size_t make_message(cvol_mpi_radix_k *r)
{
    cvol_mpi_cursor cursor = cvol_mpi_cursor_of(&r->fragment);
    return cvol_mpi_message_cut(r->sent, &cursor, SIZE_MAX, &r->blend);
}

static void send(cvol_mpi_radix_k *r, int to, int tag)
{
    const size_t cells = make_message(r);
    MPI_Send(r->sent, (int)cells, MPI_UINT64_T, to, tag, r->parts->comm);
    count(r, cells);
}

static void receive(cvol_mpi_radix_k *r, int from, int tag)
{
    const size_t cells = r->parts->memory.received.size / sizeof *r->received;
    MPI_Recv(r->received, cells < INT_MAX ? (int)cells : INT_MAX, MPI_UINT64_T, from, tag,
             r->parts->comm, MPI_STATUS_IGNORE);
}

static cvol_mpi_cursor cursor_of_message(cvol_mpi_run *message)
{
    const cvol_mpi_fragment fragment = cvol_mpi_fragment_of_message(message);
    return cvol_mpi_cursor_of(&fragment);
}

static void fold(cvol_mpi_radix_k *r)
{
    if (r->member < 0) {
        send(r, r->order[r->place - 1], TAG_FOLD);
    } else if (r->member < folded_pairs(r)) {
        make_message(r);
        receive(r, r->order[r->place + 1], TAG_FOLD);
        cvol_mpi_cursor cursors[2] = {cursor_of_message(r->sent), cursor_of_message(r->received)};
        cvol_mpi_fragment_merge(&r->fragment, cursors, 2, &r->blend);
    }
}

/* A group of k processes; member j of it has this process's number + (j - digit) stride. */
typedef struct group {
    int round, k, digit, stride;
    int pending; /* number of requests */
    MPI_Request requests[2 * CVOL_MPI_MOST_K];
    cvol_mpi_run *messages[CVOL_MPI_MOST_K]; /* the fragments that this process merges */
} group;

static int rank_in(const cvol_mpi_radix_k *r, const group *g, int j)
{
    return rank_of(r, r->member + (j - g->digit) * g->stride);
}

static void begin_to_receive(cvol_mpi_radix_k *r, group *g)
{
    int own[2] = {r->piece[0], r->piece[1]};
    choose_part(own, g->k, g->digit);
    const size_t most = cvol_mpi_message_most(pixels_of(r, own), &r->blend);
    cvol_mpi_run *to = r->received;
    for (int j = 0; j < g->k; j++) {
        if (j == g->digit)
            continue;
        MPI_Irecv(to, (int)most, MPI_UINT64_T, rank_in(r, g, j), g->round, r->parts->comm,
                  &g->requests[g->pending++]);
        g->messages[j] = to;
        to += most;
    }
}

static void begin_to_send(cvol_mpi_radix_k *r, group *g)
{
    cvol_mpi_cursor cursor = cvol_mpi_cursor_of(&r->fragment);
    cvol_mpi_run *to = r->sent;
    for (int j = 0; j < g->k; j++) {
        int part[2] = {r->piece[0], r->piece[1]};
        choose_part(part, g->k, j);
        const size_t cells = cvol_mpi_message_cut(to, &cursor, r->bounds[part[1]], &r->blend);
        if (j == g->digit) {
            g->messages[j] = to;
        } else {
            MPI_Isend(to, (int)cells, MPI_UINT64_T, rank_in(r, g, j), g->round, r->parts->comm,
                      &g->requests[g->pending++]);
            count(r, cells);
        }
        to += cells;
    }
}

static void run_round(cvol_mpi_radix_k *r, int round, int stride)
{
    const int k = r->rounds.factors[round];
    group g = {.round = round, .k = k, .digit = r->member / stride % k, .stride = stride};
    cvol_mpi_cursor cursors[CVOL_MPI_MOST_K];
    MPI_Status unused[2 * CVOL_MPI_MOST_K]; /* GCC warns of MPICH's MPI_STATUSES_IGNORE */
    begin_to_receive(r, &g);
    begin_to_send(r, &g);
    MPI_Waitall(g.pending, g.requests, unused);
    for (int j = 0; j < k; j++)
        cursors[j] = cursor_of_message(g.messages[j]);
    cvol_mpi_fragment_merge(&r->fragment, cursors, (size_t)k, &r->blend);
    choose_part(r->piece, k, g.digit);
}

void cvol_mpi_radix_k_composite(cvol_mpi_radix_k *r)
{
    cvol_mpi_fragment_read(&r->fragment, r->lines, r->spans, &r->blend);
    fold(r);
    for (int i = 0, stride = 1; i < r->rounds.count && r->member >= 0; i++) {
        run_round(r, i, stride);
        stride *= r->rounds.factors[i];
    }
}

void cvol_mpi_radix_k_gather(cvol_mpi_radix_k *r)
{
    int messages = r->rounds.members;
    if (r->place != r->root) {
        if (r->member >= 0)
            send(r, 0, TAG_GATHER);
        return;
    }
    if (r->member >= 0) {
        cvol_mpi_fragment_write(r->lines, &r->fragment, &r->blend);
        messages--;
    }
    for (; messages > 0; messages--) {
        receive(r, MPI_ANY_SOURCE, TAG_GATHER);
        const cvol_mpi_fragment fragment = cvol_mpi_fragment_of_message(r->received);
        cvol_mpi_fragment_write(r->lines, &fragment, &r->blend);
    }
}
