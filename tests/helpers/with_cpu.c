/* Runs a command with the kernels of one instruction set. usage: with_cpu base|avx2|avx512 COMMAND
 * [ARGUMENT...] Exits with 77, which CTest reports as skipped, if the processor lacks the set. */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/cpu.h"

enum { SKIPPED = 77, MISUSED = 2 };

int main(int argc, char **argv)
{
    if (argc < 3) {
        fprintf(stderr, "usage: with_cpu base|avx2|avx512 COMMAND [ARGUMENT...]\n");
        return MISUSED;
    }
    setenv("CVOL_CPU", argv[1], 1);
    const char *has = cvol_cpu_name(cvol_cpu_best());
    if (strcmp(has, argv[1])) {
        printf("skipped: this processor has no %s, only %s\n", argv[1], has);
        return SKIPPED;
    }
    execv(argv[2], argv + 2);
    perror(argv[2]);
    return MISUSED;
}
