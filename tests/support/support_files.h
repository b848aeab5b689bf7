/* The context and the folder of a test that writes files. */
#ifndef CVOL_TESTS_SUPPORT_FILES_H
#define CVOL_TESTS_SUPPORT_FILES_H

#include "support.h"
#include "support_context.h"

extern char *folder;    /* fresh and empty at first */
extern char *file_path; /* FOLDER/a.cvol */

/* For cmocka: make the context, with two threads, the folder and the path; and free them with the
 * files. */
int files_setup(void **state);
int files_teardown(void **state);

#endif
