/* failing_picture FILE RANK REPORT: the renderer of process RANK has no transfer function, so its
 * picture fails before the common work. Each process prints the message that it gets; status 0 if
 * all get an error. With REPORT 1 they ask for a report. */
#include <stdio.h>
#include <stdlib.h>

#include "cvol/mpi.h"

/* CVOL_OK, or the code of what failed before the picture. */
static int prepare(cvol_context *context, cvol_array **array, cvol_renderer **renderer,
                   cvol_transfer **transfer, cvol_image **image, const char *path)
{
    static const cvol_transfer_point points[] = {{0, 1, 1, 1, 0}, {200, 1, 1, 1, 0.3}};
    int code = cvol_array_read_part(context, array, NULL, path, NULL);
    if (!code)
        code = cvol_renderer_create(context, renderer, CVOL_ENGINE_SHEET,
                                    CVOL_SOURCE(.array = *array));
    if (!code)
        code = cvol_transfer_create(context, transfer, points, 2);
    return code ? code : cvol_image_create_float(context, image, 64, 64);
}

int main(int argc, char **argv)
{
    cvol_context *context = cvol_context_create();
    cvol_array *array = NULL;
    cvol_renderer *renderer = NULL;
    cvol_transfer *transfer = NULL;
    cvol_image *image = NULL;
    cvol_mpi_parts *parts = NULL;
    cvol_mpi_render_report report;
    cvol_render_options options = cvol_render_options_defaults();
    int rank;
    if (argc != 4 || !context || MPI_Init(&argc, &argv))
        return 2;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    options.width = options.height = 64;
    int code = prepare(context, &array, &renderer, &transfer, &image, argv[1]);
    if (!code && rank != atoi(argv[2]))
        code = cvol_renderer_set_transfer(context, renderer, transfer);
    if (!code)
        code = cvol_mpi_parts_create(context, &parts, array, transfer, &options, MPI_COMM_WORLD);
    if (code)
        MPI_Abort(MPI_COMM_WORLD, 3);
    code = cvol_mpi_render(context, atoi(argv[3]) ? &report : NULL, parts, renderer, image,
                           &options);
    printf("%s\n", code ? cvol_context_message(context) : "drawn");
    cvol_mpi_parts_free(parts);
    cvol_image_free(image);
    cvol_transfer_free(transfer);
    cvol_renderer_free(renderer);
    cvol_array_free(array);
    cvol_context_free(context);
    MPI_Finalize();
    return code ? 0 : 1;
}
