/* Common code of tests of files: a temporary folder and bytes in it. */
#ifndef CVOL_TESTS_SUPPORT_H
#define CVOL_TESTS_SUPPORT_H

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* Sanitizers and counters make tests up to ten times slower; they check code paths, not figures.
 * Such builds define CVOL_TESTS_FEWER: a test tries one in SUPPORT_STRIDE of the cases that differ
 * only in numbers, one in SUPPORT_DAMAGE of the offsets of damage (fuzz/ tries millions), and
 * volumes of side SUPPORT_SIDE(n) if size is not essential. */
#ifdef CVOL_TESTS_FEWER
#define SUPPORT_STRIDE 3
#define SUPPORT_DAMAGE 53
#define SUPPORT_SIDE(n) ((n) / 2)
#else
#define SUPPORT_STRIDE 1
#define SUPPORT_DAMAGE 1
#define SUPPORT_SIDE(n) (n)
#endif

/* The stride for many similar cases: narrower instruction sets try one in three. Their kernels
 * share the source with the widest set's, which tries all. With sanitizers, one in seven. */
static inline int support_stride(void)
{
    const char *set = getenv("CVOL_CPU");
    return SUPPORT_STRIDE > 1 ? 7 : !set || !strcmp(set, "avx512") ? 1 : 3;
}

/* The case after k, for such a stride. Steps differ, so that cases that k % 2 or k % 3
 * distinguishes all occur. */
static inline int support_next(int k)
{
    const unsigned stride = (unsigned)support_stride();
    return k + 1 + (int)(((unsigned)k * 2654435761u >> 16) % (2 * stride - 1));
}

/* 1 if CVOL_TEST_VERBOSE is set: tests then print their measurements. Their assertions are the
 * same. */
int test_verbose(void);

/* Chooses a locale with a decimal comma, or prints that there is none. Returns the locale before,
 * for support_locale_restore, which frees it. */
char *support_locale_with_comma(void);
void support_locale_restore(char *before);

/* A fresh, empty folder. support_folder_remove deletes it with the files in it and frees the
 * name. */
char *support_folder_make(void);
void support_folder_remove(char *folder);
/* The number of files in the folder, hidden ones too. */
size_t support_folder_count(const char *folder);

/* FOLDER/NAME; the caller frees it. */
char *support_path(const char *folder, const char *name);
/* Writes a whole file; the test fails if that is impossible. */
void support_write(const char *path, const void *data, size_t size);
void support_write_text(const char *path, const char *text);
/* Reads a whole file; the caller frees it. */
unsigned char *support_read(const char *path, size_t *size);
/* A .cvol file with its sections one after the other, packed (section PACK) or not; frees `data`,
 * and the caller frees the result. The test fails if it cannot be unpacked. */
unsigned char *support_unpack(unsigned char *data, size_t *size);

#endif
