/* Wide names and errors of Windows, for the files of this folder. */
#ifndef CVOL_WINDOWS_WIDE_H
#define CVOL_WINDOWS_WIDE_H

#include <wchar.h>

/* The UTF-8 text in UTF-16; NULL and errno without memory or if it is no UTF-8. The caller frees
 * it.
 */
wchar_t *cvol_wide(const char *text);
/* The UTF-16 text in UTF-8, the same. */
char *cvol_narrow(const wchar_t *text);
/* Sets errno to the reason why the last call of Windows failed; returns -1. */
int cvol_windows_fail(void);
/* FOLDER/NAME, of an open folder; the caller frees it. */
char *cvol_path_inside(int folder, const char *name);
/* The path of an open file or folder, links resolved, with '/'. The caller frees it. */
char *cvol_path_of(void *handle);
/* Replaces the six X at the end of a pattern by random letters. */
void cvol_randomize(char *pattern);

#endif
