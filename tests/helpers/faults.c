/* faults.so: a shared object for LD_PRELOAD, under which one call of a family fails. For
 * tests/failures/failures.py.
 *
 * It counts calls between the begin and the end of main() (a program that is not cvol itself calls
 * faults_begin()). The variables of the environment, which the process does not pass on to its
 * children:
 *
 *   CVOL_FAULT=FAMILY:N:ERRNO   call N of the family, from 1, fails with this errno
 *   CVOL_FAULT=FAMILY:N+:ERRNO  call N and all later ones
 *   CVOL_FAULT_RECORD=DEPTH     records every call instead, and a hash of its last frames
 *   CVOL_FAULT_SHORT=BYTES      each read and each write transfers at most so many bytes
 *   CVOL_FAULT_EINTR=K          each K-th read, write and open fails with EINTR
 *   CVOL_FAULT_SPACE=BYTES      writes after so many bytes fail with ENOSPC
 *   CVOL_FAULT_NAMED=1          the file system has no files without a name (O_TMPFILE), and does
 *                               not exchange names (RENAME_EXCHANGE)
 *   CVOL_FAULT_ONLY=NAME        counts only calls by objects whose file name contains NAME
 *   CVOL_FAULT_LATE=1           waits for faults_begin()
 *   CVOL_FAULT_REPORT=FILE      the call that failed and its stack, or the recorded calls
 *
 * The C library's own streams call read() and write() inside of the C library. So fopen(), fdopen()
 * and stdout give streams whose functions are those of this file. Calls by libgomp are not counted:
 * it ends the process itself, with "libgomp: Out of memory allocating" or "libgomp: Thread creation
 * failed", and no program can prevent that. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#define PUBLIC __attribute__((visibility("default")))
#define CALLER __builtin_return_address(0)

enum { FRAMES = 48, RECORDS = 1 << 22 };

typedef enum family {
    MEMORY,
    READ,
    WRITE,
    SYNC,
    NAME,
    MAP,
    OPEN,
    CLOSE,
    SIZE,
    STATUS,
    THREAD,
    FAMILIES
} family;

static const char *const family_names[FAMILIES] = {
    "memory", "read", "write", "sync", "name", "map", "open", "close", "size", "status", "thread"};

static const struct {
    const char *name;
    int value;
} error_names[] = {{"ENOMEM", ENOMEM}, {"EIO", EIO},       {"ENOSPC", ENOSPC}, {"EMFILE", EMFILE},
                   {"EAGAIN", EAGAIN}, {"EDQUOT", EDQUOT}, {"EACCES", EACCES}, {"EROFS", EROFS}};

typedef struct record {
    uint32_t family;
    uint64_t stack;
} record;

static atomic_int is_active;
static atomic_ulong counts[FAMILIES];
static atomic_long space = -1;
static atomic_ulong interruptions;
static family failing = FAMILIES;
static unsigned long failing_call;
static int failing_after, failing_error, record_depth, is_named;
static size_t short_bytes;
static unsigned long interrupt_each;
static char report_name[4096], only[256];
static record *records;
static atomic_ulong record_count;
static uintptr_t gomp_begin, gomp_end;
static __thread int is_inside __attribute__((tls_model("initial-exec")));

#define NEXT(type, name, ...)                     \
    static type (*next)(__VA_ARGS__);             \
    if (!next) {                                  \
        is_inside++;                              \
        *(void **)&next = dlsym(RTLD_NEXT, name); \
        is_inside--;                              \
    }

/* ---- reports --------------------------------------------------------------------------------- */

static void put(int fd, const char *text)
{
    (void)!syscall(SYS_write, fd, text, strlen(text));
}

static void put_number(int fd, uint64_t number, unsigned base)
{
    char text[24], *next = text + sizeof text;
    *--next = 0;
    do
        *--next = "0123456789abcdef"[number % base];
    while (number /= base);
    put(fd, next);
}

/* The offset in its object, so that stacks of two runs can be compared. */
static uint64_t offset_of(void *address, const char **object)
{
    Dl_info info;
    if (!dladdr(address, &info) || !info.dli_fbase)
        return 0;
    *object = info.dli_fname;
    return (uint64_t)((char *)address - (char *)info.dli_fbase);
}

static void report_fault(family f, unsigned long call)
{
    void *frames[FRAMES];
    const int fd = report_name[0] ? (int)syscall(SYS_openat, AT_FDCWD, report_name,
                                                 O_WRONLY | O_CREAT | O_APPEND, 0600)
                                  : -1;
    if (fd < 0)
        return;
    put(fd, "fault ");
    put(fd, family_names[f]);
    put(fd, " ");
    put_number(fd, call, 10);
    const int count = backtrace(frames, FRAMES);
    for (int i = 2; i < count; i++) {
        const char *object = "?";
        const uint64_t offset = offset_of(frames[i], &object);
        put(fd, " ");
        put(fd, object);
        put(fd, "+0x");
        put_number(fd, offset, 16);
    }
    put(fd, "\n");
    syscall(SYS_close, fd);
}

static void record_call(family f)
{
    void *frames[FRAMES];
    const char *object;
    const int count = backtrace(frames, record_depth + 2);
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (int i = 2; i < count; i++)
        hash = (hash ^ offset_of(frames[i], &object)) * UINT64_C(0x100000001b3);
    const unsigned long index = atomic_fetch_add(&record_count, 1);
    if (index < RECORDS)
        records[index] = (record){(uint32_t)f, hash};
}

static void report_records(void)
{
    const int fd = (int)syscall(SYS_openat, AT_FDCWD, report_name, O_WRONLY | O_CREAT | O_TRUNC,
                                0600);
    unsigned long count = atomic_load(&record_count);
    if (fd < 0)
        return;
    if (count > RECORDS)
        count = RECORDS;
    for (size_t done = 0; done < count * sizeof *records;) {
        const long wrote = syscall(SYS_write, fd, (char *)records + done,
                                   count * sizeof *records - done);
        if (wrote <= 0)
            break;
        done += (size_t)wrote;
    }
    syscall(SYS_close, fd);
}

/* ---- which calls count ----------------------------------------------------------------------- */

static const char *base_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static int is_counted(void *caller)
{
    if (!atomic_load_explicit(&is_active, memory_order_relaxed) || is_inside)
        return 0;
    if ((uintptr_t)caller >= gomp_begin && (uintptr_t)caller < gomp_end)
        return 0;
    if (only[0]) {
        Dl_info info;
        is_inside++;
        const int fits = dladdr(caller, &info) && info.dli_fname &&
                         strstr(base_of(info.dli_fname), only);
        is_inside--;
        if (!fits)
            return 0;
    }
    return 1;
}

/* Counts a call; 1: it must fail, with errno set. */
static int fails(family f, void *caller)
{
    if (!is_counted(caller))
        return 0;
    const unsigned long call = atomic_fetch_add(&counts[f], 1) + 1;
    if (record_depth) {
        is_inside++;
        record_call(f);
        is_inside--;
        return 0;
    }
    if (f != failing || (failing_after ? call < failing_call : call != failing_call))
        return 0;
    if (call == failing_call) {
        is_inside++;
        report_fault(f, call);
        is_inside--;
    }
    errno = failing_error;
    return 1;
}

static int is_interrupted(void *caller)
{
    if (!interrupt_each || !is_counted(caller))
        return 0;
    if ((atomic_fetch_add(&interruptions, 1) + 1) % interrupt_each)
        return 0;
    errno = EINTR;
    return 1;
}

static size_t shorten(size_t size, void *caller)
{
    return short_bytes && size > short_bytes && is_counted(caller) ? short_bytes : size;
}

/* The bytes that still fit on the disk; 0 with errno set: none. */
static size_t take_space(size_t size, void *caller)
{
    if (!size || !is_counted(caller) || atomic_load(&space) < 0)
        return size;
    const long left = atomic_load(&space) - 1;
    if (!left) {
        errno = ENOSPC;
        return 0;
    }
    if ((size_t)left < size)
        size = (size_t)left;
    atomic_fetch_sub(&space, (long)size);
    return size;
}

/* ---- memory ---------------------------------------------------------------------------------- */

/* dlsym() may allocate; the C library's own functions serve until the next ones are known. */
// NOLINTBEGIN(bugprone-reserved-identifier): names of the C library
extern void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t),
    *__libc_memalign(size_t, size_t);
// NOLINTEND(bugprone-reserved-identifier)

PUBLIC void *malloc(size_t size)
{
    if (fails(MEMORY, CALLER))
        return NULL;
    NEXT(void *, "malloc", size_t)
    return next ? next(size) : __libc_malloc(size);
}

PUBLIC void *calloc(size_t count, size_t size)
{
    if (fails(MEMORY, CALLER))
        return NULL;
    static __thread int is_looking __attribute__((tls_model("initial-exec")));
    static void *(*next)(size_t, size_t);
    if (!next && !is_looking) {
        is_looking = 1;
        *(void **)&next = dlsym(RTLD_NEXT, "calloc");
        is_looking = 0;
    }
    return next ? next(count, size) : __libc_calloc(count, size);
}

PUBLIC void *realloc(void *memory, size_t size)
{
    if (size && fails(MEMORY, CALLER))
        return NULL;
    NEXT(void *, "realloc", void *, size_t)
    return next ? next(memory, size) : __libc_realloc(memory, size);
}

PUBLIC void *reallocarray(void *memory, size_t count, size_t size)
{
    if (count && size && fails(MEMORY, CALLER))
        return NULL;
    NEXT(void *, "reallocarray", void *, size_t, size_t)
    return next(memory, count, size);
}

PUBLIC void *aligned_alloc(size_t alignment, size_t size)
{
    if (fails(MEMORY, CALLER))
        return NULL;
    NEXT(void *, "aligned_alloc", size_t, size_t)
    return next ? next(alignment, size) : __libc_memalign(alignment, size);
}

PUBLIC void *memalign(size_t alignment, size_t size)
{
    if (fails(MEMORY, CALLER))
        return NULL;
    NEXT(void *, "memalign", size_t, size_t)
    return next ? next(alignment, size) : __libc_memalign(alignment, size);
}

PUBLIC int posix_memalign(void **memory, size_t alignment, size_t size)
{
    if (fails(MEMORY, CALLER))
        return ENOMEM;
    NEXT(int, "posix_memalign", void **, size_t, size_t)
    return next(memory, alignment, size);
}

/* ---- reads and writes ------------------------------------------------------------------------ */

PUBLIC ssize_t read(int fd, void *data, size_t size)
{
    if (fails(READ, CALLER) || is_interrupted(CALLER))
        return -1;
    NEXT(ssize_t, "read", int, void *, size_t)
    return next(fd, data, shorten(size, CALLER));
}

PUBLIC ssize_t pread(int fd, void *data, size_t size, off_t offset)
{
    if (fails(READ, CALLER) || is_interrupted(CALLER))
        return -1;
    NEXT(ssize_t, "pread", int, void *, size_t, off_t)
    return next(fd, data, shorten(size, CALLER), offset);
}

PUBLIC ssize_t pread64(int fd, void *data, size_t size, off_t offset)
{
    if (fails(READ, CALLER) || is_interrupted(CALLER))
        return -1;
    NEXT(ssize_t, "pread64", int, void *, size_t, off_t)
    return next(fd, data, shorten(size, CALLER), offset);
}

PUBLIC ssize_t write(int fd, const void *data, size_t size)
{
    if (fd != STDERR_FILENO) {
        if (fails(WRITE, CALLER) || is_interrupted(CALLER))
            return -1;
        const size_t fits = take_space(size, CALLER);
        if (size && !fits)
            return -1;
        size = shorten(fits, CALLER);
    }
    NEXT(ssize_t, "write", int, const void *, size_t)
    return next(fd, data, size);
}

PUBLIC ssize_t pwrite(int fd, const void *data, size_t size, off_t offset)
{
    if (fails(WRITE, CALLER) || is_interrupted(CALLER))
        return -1;
    NEXT(ssize_t, "pwrite", int, const void *, size_t, off_t)
    return next(fd, data, shorten(size, CALLER), offset);
}

PUBLIC ssize_t pwrite64(int fd, const void *data, size_t size, off_t offset)
{
    if (fails(WRITE, CALLER) || is_interrupted(CALLER))
        return -1;
    NEXT(ssize_t, "pwrite64", int, const void *, size_t, off_t)
    return next(fd, data, shorten(size, CALLER), offset);
}

/* ---- files ----------------------------------------------------------------------------------- */

static int has_mode(int flags)
{
    return flags & O_CREAT || (flags & O_TMPFILE) == O_TMPFILE;
}

#define MODE_OF(flags)               \
    mode_t mode = 0;                 \
    if (has_mode(flags)) {           \
        va_list args;                \
        va_start(args, flags);       \
        mode = va_arg(args, mode_t); \
        va_end(args);                \
    }

static int open_fails(int flags, void *caller)
{
    if (is_named && (flags & O_TMPFILE) == O_TMPFILE) {
        errno = EOPNOTSUPP;
        return 1;
    }
    return fails(OPEN, caller) || is_interrupted(caller);
}

PUBLIC int open(const char *path, int flags, ...)
{
    MODE_OF(flags)
    if (open_fails(flags, CALLER))
        return -1;
    NEXT(int, "open", const char *, int, ...)
    return next(path, flags, mode);
}

PUBLIC int open64(const char *path, int flags, ...)
{
    MODE_OF(flags)
    if (open_fails(flags, CALLER))
        return -1;
    NEXT(int, "open64", const char *, int, ...)
    return next(path, flags, mode);
}

PUBLIC int openat(int folder, const char *path, int flags, ...)
{
    MODE_OF(flags)
    if (open_fails(flags, CALLER))
        return -1;
    NEXT(int, "openat", int, const char *, int, ...)
    return next(folder, path, flags, mode);
}

PUBLIC int mkostemp(char *pattern, int flags)
{
    if (fails(OPEN, CALLER))
        return -1;
    NEXT(int, "mkostemp", char *, int)
    return next(pattern, flags);
}

PUBLIC char *mkdtemp(char *pattern)
{
    if (fails(OPEN, CALLER))
        return NULL;
    NEXT(char *, "mkdtemp", char *)
    return next(pattern);
}

PUBLIC DIR *opendir(const char *path)
{
    if (fails(OPEN, CALLER))
        return NULL;
    NEXT(DIR *, "opendir", const char *)
    return next(path);
}

PUBLIC int close(int fd)
{
    const int lost = fails(CLOSE, CALLER), error = errno;
    NEXT(int, "close", int)
    const int result = next(fd);
    if (!lost)
        return result;
    errno = error;
    return -1;
}

PUBLIC int fsync(int fd)
{
    if (fails(SYNC, CALLER))
        return -1;
    NEXT(int, "fsync", int)
    return next(fd);
}

PUBLIC int rename(const char *from, const char *to)
{
    if (fails(NAME, CALLER))
        return -1;
    NEXT(int, "rename", const char *, const char *)
    return next(from, to);
}

PUBLIC int linkat(int from_folder, const char *from, int to_folder, const char *to, int flags)
{
    if (fails(NAME, CALLER))
        return -1;
    NEXT(int, "linkat", int, const char *, int, const char *, int)
    return next(from_folder, from, to_folder, to, flags);
}

PUBLIC int renameat2(int from_folder, const char *from, int to_folder, const char *to,
                     unsigned flags)
{
    if (is_named && flags & RENAME_EXCHANGE) {
        errno = EINVAL;
        return -1;
    }
    if (fails(NAME, CALLER))
        return -1;
    NEXT(int, "renameat2", int, const char *, int, const char *, unsigned)
    return next(from_folder, from, to_folder, to, flags);
}

PUBLIC int link(const char *from, const char *to)
{
    if (fails(NAME, CALLER))
        return -1;
    NEXT(int, "link", const char *, const char *)
    return next(from, to);
}

PUBLIC int mkdir(const char *path, mode_t mode)
{
    if (fails(NAME, CALLER))
        return -1;
    NEXT(int, "mkdir", const char *, mode_t)
    return next(path, mode);
}

PUBLIC void *mmap(void *address, size_t size, int protection, int flags, int fd, off_t offset)
{
    if (fails(MAP, CALLER))
        return MAP_FAILED;
    NEXT(void *, "mmap", void *, size_t, int, int, int, off_t)
    if (!next)
        return (void *)syscall(SYS_mmap, address, size, protection, flags, fd, offset);
    return next(address, size, protection, flags, fd, offset);
}

PUBLIC void *mmap64(void *address, size_t size, int protection, int flags, int fd, off_t offset)
{
    if (fails(MAP, CALLER))
        return MAP_FAILED;
    NEXT(void *, "mmap64", void *, size_t, int, int, int, off_t)
    return next(address, size, protection, flags, fd, offset);
}

PUBLIC off_t lseek(int fd, off_t offset, int whence)
{
    if (fails(SIZE, CALLER))
        return -1;
    NEXT(off_t, "lseek", int, off_t, int)
    return next(fd, offset, whence);
}

PUBLIC off_t lseek64(int fd, off_t offset, int whence)
{
    if (fails(SIZE, CALLER))
        return -1;
    NEXT(off_t, "lseek64", int, off_t, int)
    return next(fd, offset, whence);
}

PUBLIC int ftruncate(int fd, off_t size)
{
    if (fails(SIZE, CALLER))
        return -1;
    NEXT(int, "ftruncate", int, off_t)
    return next(fd, size);
}

PUBLIC int fstat(int fd, struct stat *status)
{
    if (fails(STATUS, CALLER))
        return -1;
    NEXT(int, "fstat", int, struct stat *)
    return next(fd, status);
}

PUBLIC int stat(const char *path, struct stat *status)
{
    if (fails(STATUS, CALLER))
        return -1;
    NEXT(int, "stat", const char *, struct stat *)
    return next(path, status);
}

PUBLIC int fstatat(int folder, const char *path, struct stat *status, int flags)
{
    if (fails(STATUS, CALLER))
        return -1;
    NEXT(int, "fstatat", int, const char *, struct stat *, int)
    return next(folder, path, status, flags);
}

PUBLIC int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user)
{
    if (fails(THREAD, CALLER))
        return failing_error;
    NEXT(int, "pthread_create", pthread_t *, const pthread_attr_t *, void *(*)(void *), void *)
    is_inside++; /* its memory is that of the C library and of libgomp */
    const int result = next(thread, attributes, run, user);
    is_inside--;
    return result;
}

/* ---- streams --------------------------------------------------------------------------------- */

static int fd_of(void *cookie)
{
    return (int)(intptr_t)cookie;
}

static ssize_t cookie_read(void *cookie, char *data, size_t size)
{
    if (fails(READ, NULL))
        return -1;
    return syscall(SYS_read, fd_of(cookie), data, shorten(size, NULL));
}

/* Streams write again what a short write left. */
static ssize_t cookie_write(void *cookie, const char *data, size_t size)
{
    size_t done = 0;
    while (done < size) {
        if (fails(WRITE, NULL))
            return 0;
        const size_t fits = take_space(size - done, NULL);
        if (!fits)
            return 0;
        const ssize_t wrote = syscall(SYS_write, fd_of(cookie), data + done, shorten(fits, NULL));
        if (wrote < 0)
            return 0;
        done += (size_t)wrote;
    }
    return (ssize_t)size;
}

static int cookie_seek(void *cookie, off64_t *offset, int whence)
{
    if (fails(SIZE, NULL))
        return -1;
    const off64_t at = syscall(SYS_lseek, fd_of(cookie), *offset, whence);
    if (at < 0)
        return -1;
    *offset = at;
    return 0;
}

static int cookie_close(void *cookie)
{
    const int lost = fails(CLOSE, NULL), error = errno;
    const int result = (int)syscall(SYS_close, fd_of(cookie));
    if (!lost)
        return result;
    errno = error;
    return -1;
}

static FILE *stream_of(int fd, const char *mode)
{
    return fopencookie(
        (void *)(intptr_t)fd, mode,
        (cookie_io_functions_t){cookie_read, cookie_write, cookie_seek, cookie_close});
}

/* The C++ library reads the descriptor of its streams. */
static int wants_descriptor(void *caller)
{
    Dl_info info;
    is_inside++;
    const int wants = dladdr(caller, &info) && info.dli_fname &&
                      strstr(info.dli_fname, "libstdc++");
    is_inside--;
    return wants;
}

static FILE *open_stream(const char *path, const char *mode, void *caller)
{
    if (fails(OPEN, caller))
        return NULL;
    if (!is_counted(caller) || wants_descriptor(caller)) {
        NEXT(FILE *, "fopen", const char *, const char *)
        return next(path, mode);
    }
    const int flags = strchr(mode, '+') ? O_RDWR : mode[0] == 'r' ? O_RDONLY : O_WRONLY;
    const int fresh = mode[0] == 'w' ? O_CREAT | O_TRUNC : mode[0] == 'a' ? O_CREAT | O_APPEND : 0;
    const int fd = (int)syscall(SYS_openat, AT_FDCWD, path, flags | fresh | O_CLOEXEC, 0666);
    FILE *stream = fd < 0 ? NULL : stream_of(fd, mode);
    if (fd >= 0 && !stream)
        syscall(SYS_close, fd);
    return stream;
}

PUBLIC FILE *fopen(const char *path, const char *mode)
{
    return open_stream(path, mode, CALLER);
}

PUBLIC FILE *fopen64(const char *path, const char *mode)
{
    return open_stream(path, mode, CALLER);
}

PUBLIC FILE *fdopen(int fd, const char *mode)
{
    if (fails(OPEN, CALLER))
        return NULL;
    if (!is_counted(CALLER) || wants_descriptor(CALLER)) {
        NEXT(FILE *, "fdopen", int, const char *)
        return next(fd, mode);
    }
    return stream_of(fd, mode);
}

/* ---- begin and end --------------------------------------------------------------------------- */

static unsigned long number_of(const char *name)
{
    const char *text = getenv(name);
    return text ? strtoul(text, NULL, 10) : 0;
}

static void find_gomp(void)
{
    FILE *maps = fopen("/proc/self/maps", "r");
    char line[4352];
    while (maps && fgets(line, sizeof line, maps)) {
        unsigned long begin, end;
        if (!strstr(line, "libgomp") || sscanf(line, "%lx-%lx", &begin, &end) != 2)
            continue;
        if (!gomp_begin)
            gomp_begin = begin;
        gomp_end = end;
    }
    if (maps)
        fclose(maps);
}

static void read_settings(void)
{
    static const char *const names[] = {
        "LD_PRELOAD",        "CVOL_FAULT",       "CVOL_FAULT_RECORD",
        "CVOL_FAULT_SHORT",  "CVOL_FAULT_EINTR", "CVOL_FAULT_SPACE",
        "CVOL_FAULT_REPORT", "CVOL_FAULT_ONLY",  "CVOL_FAULT_NAMED"};
    const char *fault = getenv("CVOL_FAULT");
    const char *report = getenv("CVOL_FAULT_REPORT"), *caller = getenv("CVOL_FAULT_ONLY");
    char error[16];
    if (fault) {
        char *end = strchr(fault, ':');
        const size_t length = end ? (size_t)(end - fault) : 0;
        for (int f = 0; f < FAMILIES; f++)
            if (length == strlen(family_names[f]) && !strncmp(fault, family_names[f], length))
                failing = (family)f;
        failing_call = end ? strtoul(end + 1, &end, 10) : 0;
        failing_after = end && *end == '+';
        if (!end || sscanf(end + failing_after, ":%15s", error) != 1)
            error[0] = 0;
        for (size_t i = 0; i < sizeof error_names / sizeof *error_names; i++)
            if (!strcmp(error, error_names[i].name))
                failing_error = error_names[i].value;
        if (failing == FAMILIES || !failing_call || !failing_error) {
            put(STDERR_FILENO, "faults: CVOL_FAULT must be FAMILY:N:ERRNO\n");
            _exit(98);
        }
    }
    if (report)
        snprintf(report_name, sizeof report_name, "%s", report);
    if (caller)
        snprintf(only, sizeof only, "%s", caller);
    short_bytes = number_of("CVOL_FAULT_SHORT");
    interrupt_each = number_of("CVOL_FAULT_EINTR");
    is_named = number_of("CVOL_FAULT_NAMED") != 0;
    if (getenv("CVOL_FAULT_SPACE"))
        atomic_store(&space, (long)number_of("CVOL_FAULT_SPACE") + 1);
    record_depth = (int)number_of("CVOL_FAULT_RECORD");
    if (record_depth > FRAMES - 2)
        record_depth = FRAMES - 2;
    if (record_depth)
        records = mmap(NULL, RECORDS * sizeof *records, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        unsetenv(names[i]);
}

PUBLIC void faults_begin(void)
{
    void *frames[2];
    read_settings();
    find_gomp();
    (void)backtrace(frames, 2); /* loads what it needs */
    atomic_store(&is_active, 1);
}

PUBLIC void faults_end(void)
{
    if (!atomic_exchange(&is_active, 0))
        return;
    if (record_depth)
        report_records();
}

static int (*program_main)(int, char **, char **);

static int main_with_faults(int argc, char **argv, char **environment)
{
    if (getenv("CVOL_FAULT_LATE")) /* the program calls faults_begin() */
        return program_main(argc, argv, environment);
    FILE *out = stream_of(STDOUT_FILENO, "w");
    if (out)
        stdout = out;
    faults_begin();
    const int status = program_main(argc, argv, environment);
    faults_end();
    fflush(stdout);
    return status;
}

// NOLINTNEXTLINE(bugprone-reserved-identifier)
PUBLIC int __libc_start_main(int (*run)(int, char **, char **), int argc, char **argv,
                             void (*begin)(void), void (*end)(void), void (*unload)(void),
                             void *stack)
{
    NEXT(int, "__libc_start_main", int (*)(int, char **, char **), int, char **, void (*)(void),
         void (*)(void), void (*)(void), void *)
    program_main = run;
    return next(main_with_faults, argc, argv, begin, end, unload, stack);
}
