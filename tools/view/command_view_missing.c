/* cvol view in builds without the viewer: fails. */
#include "tools/base/cli.h"

int command_view(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    return report_error(
        EXIT_FAILED,
        "this build of cvol has no viewer (built without libmicrohttpd or libturbojpeg, or for "
        "Windows)");
}
