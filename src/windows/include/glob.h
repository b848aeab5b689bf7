/* Patterns of file names (windows/glob.c). */
#ifndef CVOL_WINDOWS_GLOB_H
#define CVOL_WINDOWS_GLOB_H

typedef struct cvol_posix_glob {
    size_t gl_pathc;
    char **gl_pathv;
} glob_t;
enum { GLOB_NOSPACE = 1, GLOB_ABORTED, GLOB_NOMATCH };
#define glob cvol_posix_glob
#define globfree cvol_posix_globfree
/* `*`, `?` and `[...]` in the last part of the path; not sorted. No flags, no handler of errors. */
int cvol_posix_glob(const char *pattern, int flags, void *handler, glob_t *found);
void cvol_posix_globfree(glob_t *found);

#endif
