/* Messages of several processes (messages.h). */
#define _POSIX_C_SOURCE 200809L
#include "tools/mpi/messages.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/context.h"
#include "cvol/mpi.h"
#include "tools/base/cli.h"

static int has_agreed;
static FILE *messages; /* of a process other than 0 */

void note_agreement(void)
{
    has_agreed = 1;
}

int silence(void)
{
    messages = tmpfile();
    return messages && freopen("/dev/null", "w", stdout) && dup2(fileno(messages), 2) >= 0;
}

void find_message(char text[MESSAGE])
{
    char line[MESSAGE];
    strcpy(text, "failed");
    fflush(stderr);
    if (!messages)
        return;
    rewind(messages);
    while (fgets(line, sizeof line, messages)) {
        line[strcspn(line, "\n")] = '\0';
        strcpy(text, strncmp(line, "cvol: ", 6) ? line : line + 6);
    }
}

void report_early_failure(void)
{
    char text[MESSAGE];
    int first;
    if (has_agreed)
        return;
    cvol_context *context = cvol_context_create();
    if (!context)
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILED);
    find_message(text);
    const int code = cvol_fail(context, CVOL_ERROR_IO, "%s", text);
    cvol_mpi_agree(context, code, &first, MPI_COMM_WORLD);
    cvol_context_free(context);
}
