/* The memory that the process used at most; no limits (windows/machine.c). */
#ifndef CVOL_WINDOWS_RESOURCE_H
#define CVOL_WINDOWS_RESOURCE_H

enum { RUSAGE_SELF, RLIMIT_AS };
#define RLIM_INFINITY UINT64_MAX

struct rusage {
    long long ru_maxrss; /* kB */
};
struct rlimit {
    uint64_t rlim_cur;
};
#define getrusage cvol_posix_getrusage
#define getrlimit cvol_posix_getrlimit
int cvol_posix_getrusage(int who, struct rusage *usage);
int cvol_posix_getrlimit(int what, struct rlimit *limit);

#endif
