/* Mappings, the machine and signals (posix.h, sys/mman.h, sys/resource.h). */
#include <sys/mman.h>
#include <sys/resource.h>

#include "windows/wide.h"

#define WIN32_LEAN_AND_MEAN
#include <windows.h>
/* After windows.h. */
#include <psapi.h>

void *cvol_posix_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset)
{
    (void)at, (void)flags;
    if (protection != PROT_READ || fd < 0) {
        errno = ENOTSUP;
        return MAP_FAILED;
    }
    const HANDLE mapping = CreateFileMappingW((HANDLE)_get_osfhandle(fd), NULL, PAGE_READONLY, 0, 0,
                                              NULL);
    void *memory = mapping ? MapViewOfFile(mapping, FILE_MAP_READ, (DWORD)((uint64_t)offset >> 32),
                                           (DWORD)offset, size)
                           : NULL;
    if (!memory)
        cvol_windows_fail();
    if (mapping)
        CloseHandle(mapping); /* the view keeps it */
    return memory ? memory : MAP_FAILED;
}

int cvol_posix_munmap(void *memory, size_t size)
{
    (void)size;
    return UnmapViewOfFile(memory) ? 0 : cvol_windows_fail();
}

long cvol_posix_sysconf(int what)
{
    SYSTEM_INFO system;
    MEMORYSTATUSEX memory = {.dwLength = sizeof memory};
    GetSystemInfo(&system);
    if (what == _SC_PAGESIZE)
        return (long)system.dwPageSize;
    if (what == _SC_NPROCESSORS_ONLN)
        return (long)system.dwNumberOfProcessors;
    return GlobalMemoryStatusEx(&memory) ? (long)(memory.ullTotalPhys / system.dwPageSize) : -1;
}

/* Windows has no call for all files of a disk: each output is on disk before it gets its name. */
void cvol_posix_sync(void)
{
}

int cvol_posix_getrusage(int who, struct rusage *usage)
{
    PROCESS_MEMORY_COUNTERS memory = {.cb = sizeof memory};
    (void)who;
    *usage = (struct rusage){0};
    if (!GetProcessMemoryInfo(GetCurrentProcess(), &memory, sizeof memory))
        return cvol_windows_fail();
    usage->ru_maxrss = (long long)(memory.PeakWorkingSetSize / 1024);
    return 0;
}

int cvol_posix_getrlimit(int what, struct rlimit *limit)
{
    (void)what;
    limit->rlim_cur = RLIM_INFINITY;
    return 0;
}

int cvol_posix_sigaction(int number, const struct sigaction *action, struct sigaction *before)
{
    if (number != SIGINT && number != SIGTERM) {
        errno = EINVAL;
        return -1;
    }
    void (*old)(int) = signal(number, action ? action->sa_handler : SIG_DFL);
    if (!action)
        signal(number, old);
    if (before)
        before->sa_handler = old;
    return 0;
}
