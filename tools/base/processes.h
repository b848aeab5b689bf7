/* Several processes that run one command on the same files (tools/mpi). */
#ifndef CVOL_TOOLS_PROCESSES_H
#define CVOL_TOOLS_PROCESSES_H

#include "cvol/cvol.h"

typedef struct process_group {
    /* Prepares the context of a command. An error code. */
    int (*begin)(cvol_context *context);
    /* Reads what this process needs of a volume. An error code. */
    int (*read)(cvol_context *context, cvol_array **out, cvol_file_report *report, const char *path,
                const cvol_file_part *part);
    /* 0: all processes know that one of them has failed. */
    int (*can_go_on)(void);
    /* Agrees on success at the end of the command: the exit status. */
    int (*end)(cvol_context *context, int status);
} process_group;

/* NULL: one process runs the command. */
extern const process_group *processes;

/* Reads an array, by one process or by several. An error code. */
int read_array(cvol_context *context, cvol_array **out, cvol_file_report *report, const char *path,
               const cvol_file_part *part);
/* 0 if the command must end, because another process has failed. */
int processes_can_go_on(void);

#endif
