/* Pictures by several processes (cvol/mpi.h): every process draws its part; a reduction composites
 * them. The operator "over" is associative but not commutative, and MPI keeps the order of ranks:
 * so the reduction runs in a communicator whose ranks are in the order in which the eye sees the
 * parts. (Molnar, Cox, Ellsworth and Fuchs, "A sorting classification of parallel rendering", 1994:
 * sort-last.) */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "mpi/parts.h"
#include "render/view/camera.h"
#include "render/view/options.h"
#include "render/view/view_ray.h"

/* Pixels of one reduction. */
#define CHUNK (1 << 20)
/* Samples by which parts overlap. */
#define OVERLAP 2
/* A surface that near to a part may belong to it: depths are rounded. */
#define ROUNDED 0.5
/* Values of a pixel of a surface. */
#define SURFACE 5

/* ---- operators on pixels ----------------------------------------------------------------- */

/* `in` is before `inout`. */
static void put_over(void *in, void *inout, int *count, MPI_Datatype *type)
{
    const float *front = in;
    float *back = inout;
    (void)type;
    for (int i = 0; i < *count; i++) {
        const float through = 1 - front[4 * i + 3];
        for (int c = 0; c < 4; c++)
            back[4 * i + c] = front[4 * i + c] + through * back[4 * i + c];
    }
}

/* Of pixels that show something; the more opaque one has the opacity. */
static void keep_extreme(float *kept, const float *other, int is_least)
{
    if (!(other[3] > 0))
        return;
    for (int c = 0; c < 3; c++)
        if (!(kept[3] > 0) || (is_least ? other[c] < kept[c] : other[c] > kept[c]))
            kept[c] = other[c];
    kept[3] = fmaxf(kept[3], other[3]);
}

static void keep_largest(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    for (int i = 0; i < *count; i++)
        keep_extreme((float *)inout + 4 * i, (const float *)in + 4 * i, 0);
}

static void keep_least(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    for (int i = 0; i < *count; i++)
        keep_extreme((float *)inout + 4 * i, (const float *)in + 4 * i, 1);
}

static void add(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    for (int i = 0; i < 4 * *count; i++)
        ((float *)inout)[i] += ((const float *)in)[i];
}

/* ---- order ------------------------------------------------------------------------------- */

/* Numbers the leaves of a node from front to back, from *next on. */
static void number_parts(const cvol_mpi_parts *parts, int node, const cvol_view *view, int *places,
                         int *next)
{
    const cvol_mpi_node *n = &parts->nodes[node];
    if (n->axis < 0) {
        places[n->below] = (*next)++;
        return;
    }
    const double at = n->at * parts->grid.spacing[n->axis];
    const int from_above = view->perspective ? view->place[n->axis] > at : view->eye[n->axis] > 0;
    number_parts(parts, from_above ? n->above : n->below, view, places, next);
    number_parts(parts, from_above ? n->below : n->above, view, places, next);
}

/* ---- pictures ---------------------------------------------------------------------------- */

/* 1 if the clip leaves something of the part. */
static int is_drawn(const cvol_part *part, const cvol_clip *clip, const cvol_grid *grid)
{
    for (int a = 0; a < 3; a++) {
        const double margin = grid->dims[a] > 1 ? 0 : 0.5;
        double from = fmax(part->from[a], -margin),
               to = fmin(part->to[a], (double)(grid->dims[a] - 1) + margin);
        if (clip->axes >> a & 1) {
            from = fmax(from, clip->from[a]);
            to = fmin(to, clip->to[a]);
        }
        if (!(from < to))
            return 0;
    }
    return 1;
}

/* Where it does not matter that a place belongs to two parts, they overlap: then no interval of a
 * ray is cut without being whole in one of them. */
static cvol_part drawn_part(const cvol_mpi_parts *parts, cvol_mode mode)
{
    cvol_part part = parts->boxes[parts->rank];
    for (int a = 0; a < 3 && mode != CVOL_MODE_COMPOSITE && mode != CVOL_MODE_XRAY; a++) {
        part.from[a] -= OVERLAP;
        part.to[a] += OVERLAP;
    }
    return part;
}

static int draw_part(cvol_context *context, const cvol_mpi_parts *parts, cvol_renderer *renderer,
                     cvol_image *image, const cvol_render_options *options, cvol_view *view)
{
    cvol_render_options own = *options;
    int code = cvol_view_make(context, view, &parts->grid, options);
    if (code)
        return code;
    own.part = drawn_part(parts, options->mode);
    memset(image->values, 0, 4 * sizeof(float) * (size_t)image->width * (size_t)image->height);
    if (!is_drawn(&own.part, &own.clip, &parts->grid))
        return CVOL_OK;
    code = cvol_renderer_render(context, renderer, image, &own);
    return code ? code : cvol_view_make(context, view, &parts->grid, &own);
}

/* Drops surfaces outside of the part, in the overlap: where a ray begins in an overlap within
 * matter, it would show a cut. The part that has the place draws it. */
static void drop_neighbours(cvol_image *image, const cvol_mpi_parts *parts, const cvol_view *view)
{
    const cvol_part *part = &parts->boxes[parts->rank];
    for (int j = 0; j < image->height; j++)
        for (int i = 0; i < image->width; i++) {
            const size_t k = (size_t)j * (size_t)image->width + (size_t)i;
            cvol_view_ray ray;
            if (!(image->values[4 * k + 3] > 0) ||
                !cvol_view_ray_make(&ray, view, parts->grid.spacing, i, j))
                continue;
            const double t = ((double)image->depth[k] - ray.depth) / ray.rise;
            for (int a = 0; a < 3; a++) {
                const double at = ray.start[a] + t * ray.direction[a];
                if (at < part->from[a] - ROUNDED || at > part->to[a] + ROUNDED)
                    image->values[4 * k + 3] = 0;
            }
        }
}

/* Multiplies means along rays by the lengths of the rays within the part. */
static void weigh_rays(cvol_image *image, const cvol_mpi_parts *parts, const cvol_view *view)
{
    for (int j = 0; j < image->height; j++)
        for (int i = 0; i < image->width; i++) {
            float *pixel = image->values + 4 * ((size_t)j * (size_t)image->width + (size_t)i);
            cvol_view_ray ray;
            const int meets = pixel[3] > 0 &&
                              cvol_view_ray_make(&ray, view, parts->grid.spacing, i, j);
            const float length = meets ? (float)(ray.far - ray.near) : 0;
            for (int c = 0; c < 3; c++)
                pixel[c] *= length;
            pixel[3] = length;
        }
}

static void divide_rays(cvol_image *image)
{
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (size_t k = 0; k < count; k++) {
        float *pixel = image->values + 4 * k;
        const float length = pixel[3];
        for (int c = 0; c < 3 && length > 0; c++)
            pixel[c] /= length;
        pixel[3] = length > 0 ? 1 : 0;
    }
}

/* Of surfaces the nearest: colours, opacity and depth. */
static void keep_nearest(void *in, void *inout, int *count, MPI_Datatype *type)
{
    (void)type;
    for (int i = 0; i < *count; i++) {
        const float *other = (const float *)in + SURFACE * i;
        float *kept = (float *)inout + SURFACE * i;
        if (other[3] > 0 && (!(kept[3] > 0) || other[4] < kept[4]))
            memcpy(kept, other, SURFACE * sizeof *kept);
    }
}

static MPI_User_function *operator_of(cvol_mode mode)
{
    return mode == CVOL_MODE_MIP    ? keep_largest
           : mode == CVOL_MODE_MIN  ? keep_least
           : mode == CVOL_MODE_XRAY ? add
           : mode == CVOL_MODE_ISO  ? keep_nearest
                                    : put_over;
}

/* Composites pixels of all processes, which are numbered by `places`, into those of process 0. */
static void composite(float *pixels, size_t count, int values, const cvol_mpi_parts *parts,
                      const int *places, cvol_mode mode)
{
    MPI_Comm ordered;
    MPI_Datatype pixel;
    MPI_Op op;
    MPI_Comm_split(parts->comm, 0, places[parts->rank], &ordered);
    MPI_Type_contiguous(values, MPI_FLOAT, &pixel);
    MPI_Type_commit(&pixel);
    MPI_Op_create(operator_of(mode), operator_of(mode) != put_over, &op);
    for (size_t first = 0; first < count; first += CHUNK) {
        const size_t left = count - first;
        float *chunk = pixels + (size_t)values * first;
        const int is_root = parts->rank == 0;
        MPI_Reduce(is_root ? MPI_IN_PLACE : chunk, is_root ? chunk : NULL,
                   (int)(left < CHUNK ? left : CHUNK), pixel, op, places[0], ordered);
    }
    MPI_Op_free(&op);
    MPI_Type_free(&pixel);
    MPI_Comm_free(&ordered);
}

/* The same for surfaces; `packed` has room for SURFACE values per pixel. */
static void composite_surfaces(cvol_image *image, float *packed, const cvol_mpi_parts *parts,
                               const int *places)
{
    const size_t count = (size_t)image->width * (size_t)image->height;
    for (size_t k = 0; k < count; k++) {
        memcpy(packed + SURFACE * k, image->values + 4 * k, 4 * sizeof *packed);
        packed[SURFACE * k + 4] = image->depth[k];
    }
    composite(packed, count, SURFACE, parts, places, CVOL_MODE_ISO);
    for (size_t k = 0; k < count && parts->rank == 0; k++)
        memcpy(image->values + 4 * k, packed + SURFACE * k, 4 * sizeof *packed);
}

static int check_image(cvol_context *context, const cvol_image *image)
{
    if (!image->values || image->depth)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "several processes draw pictures of floats, without depths");
    return CVOL_OK;
}

/* Draws and composites. Collective, also if `code` is an error. */
static int render(cvol_context *context, const cvol_mpi_parts *parts, cvol_renderer *renderer,
                  cvol_image *image, const cvol_render_options *options, int code)
{
    const size_t count = (size_t)image->width * (size_t)image->height;
    const int is_surface = options->mode == CVOL_MODE_ISO;
    int *places = cvol_allocate_zero((size_t)parts->size, sizeof *places), next = 0, rank;
    float *packed = is_surface ? cvol_allocate(SURFACE * count, sizeof *packed) : NULL;
    cvol_view view;
    if (!code && (!places || (is_surface && !packed)))
        code = cvol_fail_memory(context, SURFACE * count * sizeof *packed, "a picture of parts");
    if (!code)
        code = draw_part(context, parts, renderer, image, options, &view);
    if (!(code = cvol_mpi_agree(context, code, &rank, parts->comm))) {
        number_parts(parts, 0, &view, places, &next);
        if (options->mode == CVOL_MODE_XRAY)
            weigh_rays(image, parts, &view);
        if (is_surface)
            drop_neighbours(image, parts, &view);
        if (is_surface)
            composite_surfaces(image, packed, parts, places);
        else
            composite(image->values, count, 4, parts, places, options->mode);
        if (options->mode == CVOL_MODE_XRAY && parts->rank == 0)
            divide_rays(image);
    }
    free(places);
    free(packed);
    return code;
}

/* out: means of 2 x 2 pixels. */
static void halve(cvol_image *out, const cvol_image *image)
{
    const size_t row = 4 * (size_t)image->width;
    for (int j = 0; j < out->height; j++)
        for (int i = 0; i < out->width; i++) {
            const float *from = image->values + 2 * row * (size_t)j + 8 * (size_t)i;
            float *to = out->values + 4 * ((size_t)j * (size_t)out->width + (size_t)i);
            for (int c = 0; c < 4; c++)
                to[c] = 0.25f *
                        (from[c] + from[4 + c] + from[row + (size_t)c] + from[row + 4 + (size_t)c]);
        }
}

/* Surfaces: with depths; and the rays of a pixel may end in different parts, so the mean over four,
 * if the options have it, comes last. */
static int render_surface(cvol_context *context, const cvol_mpi_parts *parts,
                          cvol_renderer *renderer, cvol_image *image,
                          const cvol_render_options *options, int code)
{
    const int has_four = options->level == 0 && !(options->oversample > 0);
    cvol_render_options own = *options;
    cvol_image *rays = NULL, none = {.width = 0};
    if (has_four) {
        own.oversample = 1;
        own.width *= 2;
        own.height *= 2;
    }
    if (!code)
        code = cvol_image_create_float(context, &rays, own.width, own.height);
    if (!code)
        code = cvol_image_add_depth(context, rays);
    code = render(context, parts, renderer, rays ? rays : &none, &own, code);
    if (!code && parts->rank == 0 && has_four)
        halve(image, rays);
    else if (!code && parts->rank == 0)
        memcpy(image->values, rays->values,
               4 * sizeof(float) * (size_t)image->width * (size_t)image->height);
    cvol_image_free(rays);
    return code;
}

int cvol_mpi_render(cvol_context *context, const cvol_mpi_parts *parts, cvol_renderer *renderer,
                    cvol_image *image, const cvol_render_options *options)
{
    cvol_render_options full;
    int code = cvol_render_options_complete(context, &full, options);
    if (!code)
        code = check_image(context, image);
    return (!code && full.mode == CVOL_MODE_ISO ? render_surface : render)(context, parts, renderer,
                                                                           image, &full, code);
}
