/* Facts that a file does not state. */
#include "base/options.h"
#include "cvol/volume.h"

static const cvol_read_options defaults = {.size = sizeof(cvol_read_options)};

void cvol_read_options_set_defaults(cvol_read_options *options, size_t size)
{
    cvol_options_fill(options, size, &defaults, sizeof defaults);
}
