/* The viewer by several processes: process 0 serves the page and answers all requests, and for each
 * picture of a volume it gives the others an order to draw their parts. */
#define _POSIX_C_SOURCE 200809L
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/context.h"
#include "cvol/mpi.h"
#include "tools/base/cli.h"
#include "tools/mpi/messages.h"
#include "tools/mpi/work.h"
#include "tools/view/shared_pictures.h"

/* What process 0 tells the others; the path and the points of the transfer function follow. */
typedef struct picture_order {
    int is_end; /* of the viewer */
    int threads, path_bytes, point_count;
    cvol_file_part part;
    cvol_render_options options;
} picture_order;

/* One picture at a time: MPI is called by one thread at a time. */
static pthread_mutex_t turn = PTHREAD_MUTEX_INITIALIZER;

/* Waits asleep: functions of MPI that wait keep a core busy. */
static void wait_asleep(MPI_Request *request)
{
    const struct timespec pause = {0, 500000};
    for (int done = 0; !done;) {
        MPI_Test(request, &done, MPI_STATUS_IGNORE);
        if (!done)
            nanosleep(&pause, NULL);
    }
}

/* From process 0 to all. */
static void share_order(picture_order *order)
{
    MPI_Request request;
    MPI_Ibcast(order, sizeof *order, MPI_BYTE, 0, MPI_COMM_WORLD, &request);
    wait_asleep(&request);
}

/* All processes draw their parts. code: of this process, before. */
static int draw_together(cvol_context *context, int code, const viewer_shared_picture *picture)
{
    cvol_transfer *transfer = NULL;
    cvol_mpi_parts *parts = NULL;
    int rank;
    const int is_composite = picture->options->mode == CVOL_MODE_COMPOSITE;
    if (!code && is_composite)
        code = cvol_transfer_create(context, &transfer, picture->points, picture->point_count);
    if (!code && is_composite)
        code = cvol_renderer_set_transfer(context, picture->renderer, transfer);
    code = cvol_mpi_agree(context, code, &rank, MPI_COMM_WORLD);
    if (!code)
        code = cvol_mpi_parts_create(context, &parts, picture->array, transfer, picture->options,
                                     MPI_COMM_WORLD);
    if (!code)
        code = cvol_mpi_render(context, NULL, parts, picture->renderer, picture->image,
                               picture->options);
    cvol_mpi_parts_free(parts);
    cvol_transfer_free(transfer);
    return code;
}

/* ---- process 0 --------------------------------------------------------------------------- */

static int give_order(cvol_context *context, const viewer_shared_picture *picture)
{
    picture_order order = {.threads = cvol_context_threads(context),
                           .path_bytes = (int)strlen(picture->path) + 1,
                           .point_count = (int)picture->point_count,
                           .part = picture->part,
                           .options = *picture->options};
    pthread_mutex_lock(&turn);
    share_order(&order);
    MPI_Bcast((void *)(size_t)picture->path, order.path_bytes, MPI_CHAR, 0, MPI_COMM_WORLD);
    MPI_Bcast((void *)(size_t)picture->points, order.point_count * (int)sizeof(cvol_transfer_point),
              MPI_BYTE, 0, MPI_COMM_WORLD);
    const int code = draw_together(context, CVOL_OK, picture);
    pthread_mutex_unlock(&turn);
    return code;
}

static int serve(int argc, char **argv)
{
    picture_order end = {.is_end = 1};
    setenv("OMP_WAIT_POLICY", "passive", 0); /* or cvol view would start the program again */
    shared_pictures = give_order;
    const int status = command_view(argc, argv);
    share_order(&end);
    return status;
}

/* ---- the other processes ----------------------------------------------------------------- */

/* The volume of the last picture. */
typedef struct open_volume {
    char *path;
    cvol_file_part part;
    cvol_array *array;
    cvol_renderer *renderer;
} open_volume;

static void close_volume(open_volume *v)
{
    cvol_renderer_free(v->renderer);
    cvol_array_free(v->array);
    free(v->path);
    *v = (open_volume){.path = NULL};
}

/* Opens the volume of a picture, unless it is open. Takes the path. */
static int open_ordered(cvol_context *context, open_volume *v, char *path,
                        const cvol_file_part *part)
{
    if (v->renderer && !strcmp(v->path, path) && v->part.time == part->time &&
        v->part.channel == part->channel && v->part.level == part->level) {
        free(path);
        return CVOL_OK;
    }
    close_volume(v);
    v->path = path;
    v->part = *part;
    const int code = cvol_array_read_part(context, &v->array, NULL, path, part);
    return code ? code
                : cvol_renderer_create(context, &v->renderer, CVOL_ENGINE_SHEET,
                                       CVOL_SOURCE(.array = v->array));
}

static void obey(cvol_context *context, open_volume *v, const picture_order *order)
{
    const cvol_render_options *options = &order->options;
    char *path = malloc((size_t)order->path_bytes);
    cvol_transfer_point *points = malloc(((size_t)order->point_count + 1) * sizeof *points);
    cvol_image *image = NULL;
    if (!path || !points)
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILED);
    MPI_Bcast(path, order->path_bytes, MPI_CHAR, 0, MPI_COMM_WORLD);
    MPI_Bcast(points, order->point_count * (int)sizeof *points, MPI_BYTE, 0, MPI_COMM_WORLD);
    cvol_context_set_threads(context, order->threads);
    int code = open_ordered(context, v, path, &order->part);
    if (!code)
        code = cvol_image_create_float(context, &image, options->width, options->height);
    const viewer_shared_picture picture = {.array = v->array,
                                           .renderer = v->renderer,
                                           .points = points,
                                           .point_count = (size_t)order->point_count,
                                           .options = options,
                                           .image = image};
    draw_together(context, code, &picture); /* process 0 reports failures */
    cvol_image_free(image);
    free(points);
}

static int draw_until_end(void)
{
    cvol_context *context = cvol_context_create();
    open_volume v = {.path = NULL};
    picture_order order;
    if (!context)
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILED);
    for (share_order(&order); !order.is_end; share_order(&order))
        obey(context, &v, &order);
    close_volume(&v);
    cvol_context_free(context);
    return EXIT_DONE;
}

int view_together(int argc, char **argv)
{
    int rank, level;
    note_agreement();
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Query_thread(&level);
    if (level < MPI_THREAD_SERIALIZED)
        return report_error(EXIT_FAILED, "this MPI library does not allow calls by several "
                                         "threads: use cvol view");
    return rank ? draw_until_end() : serve(argc, argv);
}
