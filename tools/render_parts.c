/* Pictures that several processes draw together (render_parts.h). */
#include "render_parts.h"

const part_drawing *drawing_of_parts;

int check_parts(const scene *s, const render_arguments *a, int volumes)
{
    if (!drawing_of_parts || !a->output) /* which is refused later */
        return EXIT_DONE;
    const char *refused = a->turntable_given              ? "--turntable"
                          : a->over_time                  ? "--over-time"
                          : a->progressive                ? "--progressive"
                          : a->budget_given               ? "--budget-ms"
                          : a->poses                      ? "--poses"
                          : a->certify                    ? "--certify"
                          : a->depth_name                 ? "--depth"
                          : a->opacity_name               ? "--opacity"
                          : a->overlays.count             ? "--overlay"
                          : has_ending(a->output, ".cvi") ? "a compressed picture"
                          : volumes > 1                   ? "several volumes"
                                                          : NULL;
    if (refused)
        return report_error(EXIT_MISUSED, "cvol-mpi render does not work with %s: use cvol render",
                            refused);
    if (s->engine != CVOL_ENGINE_SHEET)
        return report_error(EXIT_MISUSED, "cvol-mpi render draws by engine sheet only");
    return EXIT_DONE;
}
