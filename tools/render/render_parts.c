/* Pictures that several processes draw together (render_parts.h). */
#include "tools/render/render_parts.h"

const part_drawing *drawing_of_parts;

/* 1 if boxes of the file can be read in place of the whole: it is a lossy volume. Levels of exact
 * files are too coarse for cameras and light. */
static int has_boxes(cvol_context *context, const render_arguments *a, const char *path)
{
    static const size_t zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    common_options common = a->common;
    cvol_file_part part = {.size = sizeof part, .begin = zero, .end = one};
    cvol_array_info info;
    cvol_array *array;
    if (!is_cvol(path) || choose_volume(context, &common, path, &part) ||
        cvol_array_read_part(context, &array, NULL, path, &part))
        return 0; /* the message comes when it is opened */
    cvol_array_get_info(&info, array);
    cvol_array_free(array);
    return info.block > 0 && info.rank == 3 && !is_exact(info.psnr_db);
}

int find_whole_level(cvol_context *context, scene *s, const render_arguments *a, int enough,
                     const char *path)
{
    cvol_grid grid;
    s->box_level = -1;
    s->path = path;
    s->common = &a->common;
    if (!drawing_of_parts || !a->output || !has_boxes(context, a, path) ||
        cvol_file_read_grid(context, &grid, path, NULL))
        return enough;
    const int level = drawing_of_parts->level(&grid);
    if (level <= enough)
        return enough;
    s->box_level = enough;
    return level;
}

int process_writes(void)
{
    return !drawing_of_parts || drawing_of_parts->rank == 0;
}

int agree_on_status(cvol_context *context, int status)
{
    return drawing_of_parts ? drawing_of_parts->agree(context, status) : status;
}

void describe_parts(json_t *object)
{
    json_t *stages = drawing_of_parts ? drawing_of_parts->describe() : NULL;
    if (stages)
        json_object_set_new(object, "stages", stages);
}

int check_parts(const scene *s, const render_arguments *a, int volumes)
{
    if (!drawing_of_parts || !a->output) /* which is refused later */
        return EXIT_DONE;
    const char *refused = a->over_time                    ? "--over-time"
                          : a->progressive                ? "--progressive"
                          : a->budget_given               ? "--budget-ms"
                          : a->poses                      ? "--poses"
                          : a->certify                    ? "--certify"
                          : a->depth_name                 ? "--depth"
                          : a->opacity_name               ? "--opacity"
                          : a->overlay.files.count        ? "--overlay"
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
