/* The part of POSIX that cvol uses and MinGW-w64 lacks, or has for narrow file names and text files
 * only. cmake/flags.cmake includes this header before every source of cvol, so that no other file
 * knows of Windows. The headers that MinGW-w64 lacks are in windows/include.
 *
 * Names of files are UTF-8, with '/' or '\' between folders. Files are binary. An open file can be
 * renamed and removed, as on POSIX, but not replaced by another one. */
#ifndef CVOL_WINDOWS_POSIX_H
#define CVOL_WINDOWS_POSIX_H

#define _GNU_SOURCE
#define _CRT_RAND_S
#include <direct.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <locale.h>
#include <math.h>
#include <process.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

/* ---- files (file.c) -------------------------------------------------------------------------- */

/* Bits that the flags of MinGW-w64's open() do not use. */
#define O_CLOEXEC 0 /* no child process gets files of cvol */
#define O_NONBLOCK 0
#define O_NOFOLLOW 0
#define O_DIRECTORY 0x1000000
#define O_TMPFILE 0x2000000 /* refused: Windows has no files without a name */
#define AT_FDCWD (-100)
#define AT_SYMLINK_FOLLOW 1
#define AT_SYMLINK_NOFOLLOW 2

struct cvol_posix_stat {
    uint64_t st_dev, st_ino;
    mode_t st_mode;
    off_t st_size;
};
#undef stat
#undef fstat
#undef lstat
#define stat cvol_posix_stat
#define lstat cvol_posix_stat
#define fstat cvol_posix_fstat
int cvol_posix_stat(const char *path, struct cvol_posix_stat *status);
int cvol_posix_fstat(int fd, struct cvol_posix_stat *status);

#define open cvol_posix_open
#define read cvol_posix_read
#define write cvol_posix_write
#define pread cvol_posix_pread
#define pwrite cvol_posix_pwrite
#define fsync cvol_posix_fsync
#define mkostemp cvol_posix_mkostemp
#define fopen cvol_posix_fopen
int cvol_posix_open(const char *path, int flags, ...);
ssize_t cvol_posix_read(int fd, void *data, size_t size);
ssize_t cvol_posix_write(int fd, const void *data, size_t size);
/* Both leave the file's position as it is. */
ssize_t cvol_posix_pread(int fd, void *data, size_t size, off_t offset);
ssize_t cvol_posix_pwrite(int fd, const void *data, size_t size, off_t offset);
int cvol_posix_fsync(int fd);
int cvol_posix_mkostemp(char *pattern, int flags);
FILE *cvol_posix_fopen(const char *path, const char *mode);

/* ---- names (name.c) -------------------------------------------------------------------------- */

#define access cvol_posix_access
#define rename cvol_posix_rename
#define link cvol_posix_link
#define linkat cvol_posix_linkat
#define unlink cvol_posix_unlink
#define remove cvol_posix_remove
#define realpath cvol_posix_realpath
#define mkdir cvol_posix_mkdir
#define rmdir cvol_posix_rmdir
#define mkdtemp cvol_posix_mkdtemp
#define chmod cvol_posix_chmod
#define fchmod cvol_posix_fchmod
#undef X_OK
#define X_OK 0 /* no such permission */
#define umask cvol_posix_umask
#define NAME_MAX (3 * 255) /* bytes of 255 UTF-16 units */
mode_t cvol_posix_umask(mode_t mode);
int cvol_posix_access(const char *path, int how);
int cvol_posix_rename(const char *from, const char *to);
int cvol_posix_link(const char *from, const char *to);
/* Fails: it is for files without a name. */
int cvol_posix_linkat(int from_folder, const char *from, int to_folder, const char *to, int flags);
int cvol_posix_unlink(const char *path);
int cvol_posix_remove(const char *path);
/* `out` is NULL; with '/' between folders. "/proc/self/exe" is the program, as on Linux. */
char *cvol_posix_realpath(const char *path, char *out);
int cvol_posix_mkdir(const char *path, mode_t mode);
int cvol_posix_rmdir(const char *path);
char *cvol_posix_mkdtemp(char *pattern);
/* Permissions come from the folder. */
int cvol_posix_chmod(const char *path, mode_t mode);
int cvol_posix_fchmod(int fd, mode_t mode);

/* ---- folders (folder.c) ---------------------------------------------------------------------- */

#define DIR cvol_posix_directory
#define dirent cvol_posix_entry
#define opendir cvol_posix_opendir
#define readdir cvol_posix_readdir
#define closedir cvol_posix_closedir
#define dirfd cvol_posix_dirfd
#define fstatat cvol_posix_fstatat
#define faccessat cvol_posix_faccessat
#define nftw cvol_posix_nftw
typedef struct cvol_posix_directory cvol_posix_directory;
struct cvol_posix_entry {
    char d_name[NAME_MAX + 1];
};
cvol_posix_directory *cvol_posix_opendir(const char *path);
struct cvol_posix_entry *cvol_posix_readdir(cvol_posix_directory *directory);
int cvol_posix_closedir(cvol_posix_directory *directory);
int cvol_posix_dirfd(cvol_posix_directory *directory);
int cvol_posix_fstatat(int folder, const char *name, struct cvol_posix_stat *status, int flags);
int cvol_posix_faccessat(int folder, const char *name, int how, int flags);

/* ---- memory and the machine (machine.c) ------------------------------------------------------ */

/* Memory that free() frees; malloc aligns to 16 bytes, and the kernels of the base set load 16
 * bytes at a time. */
#define CVOL_ALLOCATED_ALIGNMENT 16
#define aligned_alloc(alignment, size) malloc(size)

enum { _SC_PHYS_PAGES, _SC_PAGESIZE, _SC_NPROCESSORS_ONLN };
long cvol_posix_sysconf(int what);
#define sysconf cvol_posix_sysconf
void cvol_posix_sync(void);
#define sync cvol_posix_sync

/* Signals of POSIX that Windows lacks: sigaction() fails, and signal() does nothing. */
#define SIGHUP 1
#define SIGBUS 7
#define SIGPIPE 13
#define SIGXFSZ 25
struct sigaction {
    void (*sa_handler)(int);
};
int cvol_posix_sigaction(int number, const struct sigaction *action, struct sigaction *before);
#define sigaction(...) cvol_posix_sigaction(__VA_ARGS__)

/* ---- numbers --------------------------------------------------------------------------------- */

/* The macros of MinGW-w64 convert to all types, of which the compiler warns. */
#undef isnan
#undef isinf
#undef isfinite
#undef signbit
#define isnan(x) __builtin_isnan(x)
#define isinf(x) __builtin_isinf_sign(x)
#define isfinite(x) __builtin_isfinite(x)
#define signbit(x) __builtin_signbit(x)

/* ---- text, sorting, locales (text.c) --------------------------------------------------------- */

#define strndup cvol_posix_strndup
#define memmem cvol_posix_memmem
#define memrchr cvol_posix_memrchr
#define strverscmp cvol_posix_strverscmp
#define getline cvol_posix_getline
#define qsort_r cvol_posix_qsort_r
char *cvol_posix_strndup(const char *text, size_t most);
void *cvol_posix_memmem(const void *in, size_t size, const void *what, size_t length);
void *cvol_posix_memrchr(const void *in, int byte, size_t size);
int cvol_posix_strverscmp(const char *a, const char *b);
ssize_t cvol_posix_getline(char **text, size_t *bytes, FILE *file);
void cvol_posix_qsort_r(void *items, size_t count, size_t size,
                        int (*compare)(const void *, const void *, void *), void *user);

/* The C locale for this thread, and the one before: only these two uses of POSIX locales. */
typedef struct cvol_posix_locale *locale_t;
#define LC_ALL_MASK 0
locale_t cvol_posix_newlocale(int mask, const char *name, locale_t base);
locale_t cvol_posix_uselocale(locale_t locale);
void cvol_posix_freelocale(locale_t locale);
#define newlocale cvol_posix_newlocale
#define uselocale cvol_posix_uselocale
#define freelocale cvol_posix_freelocale

#endif
