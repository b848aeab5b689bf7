#include "test.h"

#include "support_files.h"

char *folder, *file_path;

int files_setup(void **state)
{
    folder = support_folder_make();
    file_path = support_path(folder, "a.cvol");
    return context_setup_two(state);
}

int files_teardown(void **state)
{
    free(file_path);
    support_folder_remove(folder);
    return context_teardown(state);
}
