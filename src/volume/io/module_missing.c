/* A system on which cvol loads no modules (CMakeLists.txt). */
#include "volume/io/module.h"

#include <stddef.h>

void *cvol_module_find(const char *module, const char *symbol)
{
    (void)module, (void)symbol;
    return NULL;
}
