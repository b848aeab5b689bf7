/* Intermediate images of several processes put together: exchange.h. */
#include "mpi/exchange.h"

#include "base/context.h"

/* Adds the seconds since the last call to a stage. */
static void end_stage(cvol_mpi_exchange *exchange, cvol_mpi_stage stage)
{
    const double now = MPI_Wtime();
    const clock_t cpu = clock();
    exchange->seconds[stage] += now - exchange->mark;
    if (stage == CVOL_MPI_DRAW)
        exchange->draw_cpu += (double)(cpu - exchange->cpu_mark) / CLOCKS_PER_SEC;
    exchange->mark = now;
    exchange->cpu_mark = cpu;
}

/* ---- agreement ----------------------------------------------------------------------------- */

static int agree_code(cvol_mpi_exchange *exchange, cvol_context *context, int code)
{
    int rank;
    code = cvol_mpi_agree(context, code, &rank, exchange->parts->comm);
    exchange->has_failed |= code != 0;
    return code;
}

static int agree(void *data, cvol_context *context, int code, size_t *value)
{
    cvol_mpi_exchange *exchange = data;
    unsigned long long largest = *value;
    end_stage(exchange, CVOL_MPI_DRAW);
    code = agree_code(exchange, context, code);
    if (code)
        return code;
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_UNSIGNED_LONG_LONG, MPI_MAX,
                  exchange->parts->comm);
    *value = (size_t)largest;
    end_stage(exchange, CVOL_MPI_WAIT);
    return CVOL_OK;
}

static int widen(void *data, cvol_context *context, int code, double range[2])
{
    cvol_mpi_exchange *exchange = data;
    double most[2] = {-range[0], range[1]};
    end_stage(exchange, CVOL_MPI_DRAW);
    code = agree_code(exchange, context, code);
    if (code)
        return code;
    MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_DOUBLE, MPI_MAX, exchange->parts->comm);
    range[0] = -most[0];
    range[1] = most[1];
    end_stage(exchange, CVOL_MPI_WAIT);
    return CVOL_OK;
}

/* Processors with different instruction sets may choose different rays. */
static int check_lines(cvol_context *context, const cvol_mpi_exchange *exchange,
                       const cvol_sheet_lines *lines)
{
    const double own[4] = {(double)lines->groups, (double)lines->count, lines->unit[0],
                           lines->unit[1]};
    double most[8];
    for (int k = 0; k < 4; k++) {
        most[2 * k] = own[k];
        most[2 * k + 1] = -own[k];
    }
    MPI_Allreduce(MPI_IN_PLACE, most, 8, MPI_DOUBLE, MPI_MAX, exchange->parts->comm);
    for (int k = 0; k < 4; k++)
        if (most[2 * k] > -most[2 * k + 1])
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "the processes chose different rays; if their processors differ, set "
                             "the environment variable CVOL_CPU=base");
    return CVOL_OK;
}

/* ---- pictures ------------------------------------------------------------------------------ */

/* All processes have the lines of the same view. */
static int composite(cvol_mpi_exchange *exchange, cvol_context *context, cvol_mpi_radix_k *radix_k)
{
    int code = cvol_mpi_radix_k_divide(context, radix_k);
    code = agree_code(exchange, context, code);
    if (code)
        return code;
    cvol_mpi_radix_k_composite(radix_k);
    end_stage(exchange, CVOL_MPI_COMPOSITE);
    cvol_mpi_radix_k_gather(radix_k);
    end_stage(exchange, CVOL_MPI_GATHER);
    return CVOL_OK;
}

static int combine(void *data, cvol_context *context, int code, const cvol_sheet_lines *lines,
                   cvol_mode mode)
{
    cvol_mpi_exchange *exchange = data;
    cvol_mpi_radix_k radix_k = {.parts = exchange->parts};
    end_stage(exchange, CVOL_MPI_DRAW);
    if (!code)
        code = cvol_mpi_radix_k_begin(context, &radix_k, exchange->parts, exchange->order, lines,
                                      mode);
    code = agree_code(exchange, context, code);
    if (!code)
        code = check_lines(context, exchange, lines);
    exchange->has_failed |= code != 0;
    end_stage(exchange, CVOL_MPI_WAIT);
    if (!code)
        code = composite(exchange, context, &radix_k);
    exchange->traffic.messages += radix_k.traffic.messages;
    exchange->traffic.bytes += radix_k.traffic.bytes;
    cvol_mpi_radix_k_end(&radix_k);
    return code;
}

void cvol_mpi_exchange_begin(cvol_mpi_exchange *exchange, cvol_mpi_parts *parts, const int *order,
                             int is_idle)
{
    *exchange = (cvol_mpi_exchange){.combine = {.is_idle = is_idle,
                                                .is_first = parts->rank == 0,
                                                .data = exchange,
                                                .agree = agree,
                                                .widen = widen,
                                                .combine = combine},
                                    .parts = parts,
                                    .order = order,
                                    .mark = MPI_Wtime(),
                                    .cpu_mark = clock()};
}

void cvol_mpi_exchange_report(cvol_mpi_render_report *report, const cvol_mpi_exchange *exchange)
{
    double s[CVOL_MPI_STAGES + 1] = {0}, most_cpu, all_cpu;
    const uint64_t sent[2] = {exchange->traffic.messages, exchange->traffic.bytes};
    uint64_t all[2], most[2];
    for (int k = 0; k < CVOL_MPI_STAGES; k++) {
        s[k] = exchange->seconds[k];
        s[CVOL_MPI_STAGES] += s[k];
    }
    MPI_Allreduce(MPI_IN_PLACE, s, CVOL_MPI_STAGES + 1, MPI_DOUBLE, MPI_MAX, exchange->parts->comm);
    MPI_Allreduce(&exchange->draw_cpu, &most_cpu, 1, MPI_DOUBLE, MPI_MAX, exchange->parts->comm);
    MPI_Allreduce(&exchange->draw_cpu, &all_cpu, 1, MPI_DOUBLE, MPI_SUM, exchange->parts->comm);
    MPI_Allreduce(sent, all, 2, MPI_UINT64_T, MPI_SUM, exchange->parts->comm);
    MPI_Allreduce(sent, most, 2, MPI_UINT64_T, MPI_MAX, exchange->parts->comm);
    *report = (cvol_mpi_render_report){.total_s = s[CVOL_MPI_STAGES],
                                       .draw_s = s[CVOL_MPI_DRAW],
                                       .draw_cpu_s = most_cpu,
                                       .all_cpu_s = all_cpu,
                                       .wait_s = s[CVOL_MPI_WAIT],
                                       .composite_s = s[CVOL_MPI_COMPOSITE],
                                       .gather_s = s[CVOL_MPI_GATHER],
                                       .warp_s = s[CVOL_MPI_WARP],
                                       .messages = all[0],
                                       .bytes = all[1],
                                       .most_messages = most[0],
                                       .most_bytes = most[1]};
}

void cvol_mpi_exchange_end(cvol_mpi_exchange *exchange)
{
    end_stage(exchange, CVOL_MPI_WARP);
}
