/* Several processes that run one command (processes.h). */
#include "tools/base/processes.h"

const process_group *processes;

int processes_can_go_on(void)
{
    return !processes || processes->can_go_on();
}
