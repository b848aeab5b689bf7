/* Pictures by several processes: each draws its part (tools/render/render_parts.h). */
#include <math.h>

#include "base/context.h"
#include "cvol/mpi.h"
#include "tools/base/cli.h"
#include "tools/mpi/frames.h"
#include "tools/mpi/messages.h"
#include "tools/mpi/work.h"
#include "tools/render/render_parts.h"

/* Samples of a level around a part that its pictures need: for gradients, and wide filters. */
#define MARGIN 10

/* Reads the samples of this process's part. A code of the library. Collective. */
static int read_box(cvol_context *context, cvol_array **out, const scene *s, const cvol_part *part)
{
    const cvol_grid *grid = input_grid(&s->in);
    common_options common = *s->common;
    size_t begin[3], end[3];
    cvol_file_part box = {
        .size = sizeof box, .begin = begin, .end = end, .level = s->box_level, .with_ranges = 1};
    for (int a = 0; a < 3; a++) {
        const double margin = MARGIN << s->box_level, last = (double)grid->dims[a];
        begin[a] = (size_t)fmax(floor(part->from[a] - margin), 0);
        end[a] = (size_t)fmin(ceil(part->to[a] + margin) + 1, last);
    }
    int rank, code = choose_volume(context, &common, s->path, &box)
                         ? cvol_fail(context, CVOL_ERROR_IO, "%s: cannot be read again", s->path)
                         : cvol_array_read_part(context, out, NULL, s->path, &box);
    code = cvol_mpi_agree(context, code, &rank, MPI_COMM_WORLD);
    return code ? code : cvol_mpi_array_find_ranges(context, *out, begin, end, MPI_COMM_WORLD);
}

/* What the pictures of a film share: the boxes, and this process's own. */
static struct shared {
    const scene *of; /* NULL: nothing */
    cvol_mpi_parts *parts;
    cvol_array *array;       /* NULL: the scene's */
    cvol_renderer *renderer; /* of the array */
} shared;

void free_drawing(void)
{
    cvol_renderer_free(shared.renderer);
    cvol_array_free(shared.array);
    cvol_mpi_parts_free(shared.parts);
    shared = (struct shared){.of = NULL};
}

/* Opens this process's box of the file. A code of the library, which all processes have. */
static int open_box(cvol_context *context, const scene *s)
{
    int rank;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    const cvol_part part = cvol_mpi_part(shared.parts, rank);
    int code = read_box(context, &shared.array, s, &part);
    if (!code)
        code = cvol_renderer_create(context, &shared.renderer, s->engine,
                                    CVOL_SOURCE(.array = shared.array, .whole = s->in.array));
    if (!code && s->transfer)
        code = cvol_renderer_set_transfer(context, shared.renderer, s->transfer);
    return cvol_mpi_agree(context, code, &rank, MPI_COMM_WORLD);
}

/* Finds the boxes of a scene. A code of the library, which all processes have. */
static int open_parts(cvol_context *context, const scene *s)
{
    int rank;
    if (s->other_count)
        return cvol_mpi_agree(context,
                              cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                                        "cvol-mpi draws one channel: choose it with --channel"),
                              &rank, MPI_COMM_WORLD);
    free_drawing();
    int code = cvol_mpi_parts_create(context, &shared.parts, s->in.array, s->transfer, &s->options,
                                     MPI_COMM_WORLD);
    if (!code && s->box_level >= 0)
        code = open_box(context, s);
    shared.of = code ? NULL : s;
    return code;
}

/* *read_s: the longest time of a process since it began to open the file. */
static int time_parts(cvol_context *context, double *read_s, const scene *s)
{
    const double start = MPI_Wtime();
    const int code = open_parts(context, s);
    *read_s = MPI_Wtime() - start + 1e-3 * s->load_ms;
    if (!code) /* then all processes are here */
        MPI_Allreduce(MPI_IN_PLACE, read_s, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
    return code;
}

/* Labels take their colours from the depths of the whole picture: process 0 draws it alone. */
static int draw_labels_alone(cvol_context *context, const scene *s, cvol_image *image)
{
    int rank, code = CVOL_OK;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (!rank)
        code = draw_labels(context, s->renderer, image, &s->options, s->numbers, s->labels,
                           s->transfer);
    return cvol_mpi_agree(context, code, &rank, MPI_COMM_WORLD);
}

static int draw_parts(cvol_context *context, const scene *s, cvol_image *image)
{
    note_agreement();
    if (s->numbers)
        return draw_labels_alone(context, s, image);
    cvol_mpi_render_report report;
    double read_s = 0;
    int code = shared.of == s ? CVOL_OK : time_parts(context, &read_s, s);
    if (!code)
        code = cvol_mpi_render(context, &report, shared.parts,
                               shared.renderer ? shared.renderer : s->renderer, image, &s->options);
    if (!code)
        note_frame(&report, read_s);
    return code;
}

static int agree(cvol_context *context, int status)
{
    int rank;
    note_agreement();
    const int failed = status ? cvol_fail(context, CVOL_ERROR_IO, "failed") : CVOL_OK,
              code = cvol_mpi_agree(context, failed, &rank, MPI_COMM_WORLD);
    return status || !code ? status : report_context_error(context, code, NULL);
}

void divide_drawing(void)
{
    static part_drawing drawing = {
        .level = cvol_mpi_level, .draw = draw_parts, .agree = agree, .describe = take_frames};
    MPI_Comm_rank(MPI_COMM_WORLD, &drawing.rank);
    drawing_of_parts = &drawing;
}
