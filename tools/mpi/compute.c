/* Commands that compute on volumes, by several processes (tools/base/processes.h). */
#include "base/context.h"
#include "cvol/mpi.h"
#include "tools/base/cli.h"
#include "tools/base/processes.h"
#include "tools/mpi/messages.h"
#include "tools/mpi/work.h"

static cvol_mpi_team *team; /* of the command's context */

static int begin(cvol_context *context)
{
    return cvol_mpi_team_create(context, &team, MPI_COMM_WORLD);
}

static int can_go_on(void)
{
    return !cvol_mpi_team_has_failed(team);
}

/* The message of a process that failed is on its standard error only. */
static int end(cvol_context *context, int status)
{
    char text[MESSAGE];
    int rank;
    note_agreement();
    if (!cvol_mpi_team_has_failed(team)) {
        if (status)
            find_message(text);
        const int own = status ? cvol_fail(context, CVOL_ERROR_IO, "%s", text) : CVOL_OK,
                  code = cvol_mpi_agree(context, own, &rank, MPI_COMM_WORLD);
        if (code && !status)
            status = report_context_error(context, code, NULL);
    }
    cvol_mpi_team_free(context, team);
    team = NULL;
    return status;
}

/* For operations that read other blocks than those around their own: each process has all. */
static int read_whole(cvol_context *context, cvol_array **out, cvol_file_report *report,
                      const char *path, const cvol_file_part *part)
{
    const int code = cvol_mpi_array_check(context, path, part);
    *out = NULL;
    return code ? code : cvol_array_read_part(context, out, report, path, part);
}

void divide_whole_operands(void)
{
    static const process_group group = {
        .begin = begin, .read = read_whole, .can_go_on = can_go_on, .end = end};
    processes = &group;
}

void divide_computing(void)
{
    static const process_group group = {
        .begin = begin, .read = cvol_mpi_array_read, .can_go_on = can_go_on, .end = end};
    processes = &group;
}
