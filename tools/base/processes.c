/* Several processes that run one command (processes.h). */
#include "tools/base/processes.h"

const process_group *processes;

int read_array(cvol_context *context, cvol_array **out, cvol_file_report *report, const char *path,
               const cvol_file_part *part)
{
    return processes ? processes->read(context, out, report, path, part)
                     : cvol_array_read_part(context, out, report, path, part);
}

int processes_can_go_on(void)
{
    return !processes || processes->can_go_on();
}
