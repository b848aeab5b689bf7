/* The frame of a picture around what is visible (cvol_camera_fit).
 *
 * Cells of the low-resolution volume are projected; their extinction times volume over the area of
 * a point of the projection is its optical depth. Points above DEPTH_MIN are visible. The frame
 * holds all of them but SPECKS of their number on each side, which may be single bright samples of
 * noise. Where no point or few are visible, an object may be too small for the cells: then the
 * frame holds the box of its samples (fit_small.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/options.h"
#include "cvol/look.h"
#include "render/light/extinction.h"
#include "render/look/fit_small.h"
#include "render/sheet/coarse_level.h"
#include "render/view/camera.h"

#define DEPTH_MIN 0.04
#define SPECKS 0.0005
#define POINTS 160 /* of the projection along each axis */
/* In modes without opacity, everything that is not black is visible. */
#define GREY_DEPTH_MIN 0.15
#define RADIANS_PER_DEGREE 0.017453292519943295
#define LEAST_EXTENT 1e-3 /* of a frame, in diagonals of the volume */
/* Cells are projected in parts, not as one point, if they are this many points long, as in small
 * volumes, or if what is visible is less than so many cells wide. */
#define LONG_CELL 8
#define FEW_CELLS 8
/* A frame of less than so many cells is that of samples (fit_small.h). */
#define UNRESOLVED 3

/* A projection along one view: optical depths, about the middle of the volume. */
typedef struct shadow {
    double right[3], up[3], eye[3];
    double point; /* side of a point in the world */
    float *depths;
    int is_grey;                 /* a mode without opacity */
    double share;                /* of the least depth: see project */
    const cvol_small_box *small; /* instead of cells, or NULL */
} shadow;

/* The extent along an axis of the picture, from the middle of the volume. */
typedef struct extent {
    double from, to;
} extent;

/* Part `part` of cell `cell` of a volume. */
typedef struct place_in_cell {
    size_t cell, part;
} place_in_cell;

/* The middle of a part of a cell, from the middle of the volume. */
static void find_place(double place[3], const cvol_coarse *coarse, const cvol_grid *grid,
                       place_in_cell at, const size_t parts[3])
{
    for (int a = 0; a < 3; a++) {
        const double cell = (double)(at.cell % coarse->dims[a]),
                     part = ((double)(at.part % parts[a]) + 0.5) / (double)parts[a] - 0.5;
        place[a] = (coarse->first[a] + (cell + part) * coarse->pitch[a] -
                    (double)(grid->dims[a] - 1) / 2) *
                   grid->spacing[a];
        at.cell /= coarse->dims[a];
        at.part /= parts[a];
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The numbers of parts of a cell along the axes; their product. A part is at most one point long,
 * if cells are long or `fine` is set. */
static size_t count_parts(size_t parts[3], const cvol_coarse *coarse, const cvol_grid *grid,
                          double point, int fine)
{
    double longest = 0, lengths[3];
    for (int a = 0; a < 3; a++) {
        lengths[a] = coarse->pitch[a] * grid->spacing[a] / point;
        longest = fmax(longest, lengths[a]);
    }
    for (int a = 0; a < 3; a++)
        parts[a] = longest < LONG_CELL && !fine ? 1 : (size_t)ceil(lengths[a]);
    return parts[0] * parts[1] * parts[2];
}

/* A cell that is projected as one point is as deep there as if it were that small. In grey modes,
 * whose extinctions are low, a cell that is visible so is visible in parts, too. */
static void project(shadow *out, const cvol_coarse *coarse, const cvol_grid *grid,
                    const float *extinction, int fine)
{
    size_t parts[3];
    const size_t count = cvol_coarse_count(coarse),
                 all_parts = count_parts(parts, coarse, grid, out->point, fine);
    const double mean = (grid->spacing[0] + grid->spacing[1] + grid->spacing[2]) / 3;
    double volume = mean * mean;
    for (int a = 0; a < 3; a++)
        volume *= coarse->length[a] / (double)parts[a];
    double side = out->point;
    for (int a = 0; a < 3; a++)
        side = fmax(side, coarse->pitch[a] * grid->spacing[a]);
    out->share = out->is_grey && all_parts > 1 ? out->point * out->point / (side * side) : 1;
    memset(out->depths, 0, (size_t)POINTS * POINTS * sizeof *out->depths);
    for (size_t i = 0; i < count; i++)
        for (size_t part = 0; part < all_parts && extinction[i] > 0; part++) {
            double place[3];
            find_place(place, coarse, grid, (place_in_cell){i, part}, parts);
            const int x = (int)(dot(place, out->right) / out->point + POINTS / 2.0),
                      y = (int)(dot(place, out->up) / out->point + POINTS / 2.0);
            if (x >= 0 && x < POINTS && y >= 0 && y < POINTS)
                out->depths[x + POINTS * y] += extinction[i] *
                                               (float)(volume / (out->point * out->point));
        }
}

/* The columns, or rows, of visible points, without specks; 0 if none is visible. */
static int find_extent(extent *out, const shadow *of, double least, int across)
{
    double counts[POINTS] = {0}, all = 0, sum = 0;
    int from = 0, to = POINTS - 1;
    for (int i = 0; i < POINTS * POINTS; i++)
        if ((double)of->depths[i] > least * of->share) {
            counts[across ? i % POINTS : i / POINTS] += 1;
            all += 1;
        }
    if (!(all > 0))
        return 0;
    const double specks = SPECKS * all;
    while (sum + counts[from] <= specks)
        sum += counts[from++];
    for (sum = 0; sum + counts[to] <= specks; to--)
        sum += counts[to];
    out->from = (from - POINTS / 2.0) * of->point;
    out->to = (to + 1 - POINTS / 2.0) * of->point;
    return 1;
}

/* An axis of one sample is as thick as its spacing. */
static double half_side(const cvol_grid *grid, int axis)
{
    const size_t n = grid->dims[axis];
    return (n > 1 ? (double)(n - 1) / 2 : 0.5) * grid->spacing[axis];
}

/* The extent of the volume's box along a direction. */
static extent extent_of_box(const cvol_grid *grid, const double direction[3])
{
    double half = 0;
    for (int a = 0; a < 3; a++)
        half += fabs(direction[a]) * half_side(grid, a);
    return (extent){-half, half};
}

/* The rectangle that the visible part covers, and the middle of its depth. */
typedef struct frame {
    extent x, y;
    double depth;
    int is_coarse; /* nothing is visible, or less than cells resolve */
} frame;

/* How the frame is seen. */
typedef struct perspective {
    double tangent; /* of half the vertical field of view; 0: parallel projection */
    double shape;   /* height over width of the picture */
    double least;   /* least optical depth of a visible point */
} perspective;

static int are_few_cells(const extent found[2], const cvol_coarse *coarse, const cvol_grid *grid,
                         double few)
{
    const double width = fmax(found[0].to - found[0].from, found[1].to - found[1].from);
    double cell = 0;
    for (int a = 0; a < 3; a++)
        cell = fmax(cell, coarse->pitch[a] * grid->spacing[a]);
    return width < few * cell;
}

/* In perspective, the extents of a frame that holds everything. A point at (u, v) from the middle
 * of the picture and w nearer to the eye than it, at the distance d, is seen at v d / (d - w). With
 * t = tan(fov / 2) and the half height d t of the picture, it is within the share s of it if
 * v / s + w t <= d t. So what matters are the extents along the directions +-up / s + t eye, and
 * likewise to the sides. */
static void widen(frame *out, const shadow *of, const cvol_coarse *coarse, const cvol_grid *grid,
                  const float *extinction, const perspective *lens)
{
    shadow slanted = *of;
    extent *const sides[2] = {&out->x, &out->y};
    const double *const axes[2] = {of->right, of->up};
    for (int k = 0; k < 2; k++) {
        const double share = CVOL_FIT_SHARE / (k ? 1 : lens->shape);
        double most[2];
        memcpy(slanted.up, axes[!k], sizeof slanted.up);
        for (int sign = 0; sign < 2; sign++) {
            const double side = sign ? -1 / share : 1 / share, length = hypot(side, lens->tangent);
            for (int a = 0; a < 3; a++)
                slanted.right[a] = (side * axes[k][a] + lens->tangent * of->eye[a]) / length;
            const extent box = extent_of_box(grid, slanted.right);
            extent along = box, finer;
            project(&slanted, coarse, grid, extinction, 0);
            if (find_extent(&along, &slanted, lens->least, 1)) { /* near cells look large */
                project(&slanted, coarse, grid, extinction, 1);
                if (find_extent(&finer, &slanted, lens->least, 1))
                    along.to = fmax(along.to, finer.to);
            } else
                along = box;
            most[sign] = length * fmin(along.to, box.to) - lens->tangent * out->depth;
        }
        *sides[k] = (extent){-most[1] * share, most[0] * share};
    }
}

/* The extent of a box along a direction of any length. */
static extent extent_along(const cvol_small_box *box, const double direction[3])
{
    const double middle = dot(box->middle, direction);
    double half = 0;
    for (int a = 0; a < 3; a++)
        half += fabs(direction[a]) * box->half[a];
    return (extent){middle - half, middle + half};
}

/* The frame of a box; see widen. */
static void frame_box(frame *out, const shadow *of, const perspective *lens, const double *depth)
{
    extent *const sides[2] = {&out->x, &out->y};
    const double *const axes[2] = {of->right, of->up};
    out->depth = depth ? *depth : dot(of->small->middle, of->eye);
    for (int k = 0; k < 2; k++) {
        const double share = CVOL_FIT_SHARE / (k ? 1 : lens->shape);
        double most[2];
        for (int sign = 0; sign < 2; sign++) {
            double slanted[3];
            for (int a = 0; a < 3; a++)
                slanted[a] = (sign ? -1 : 1) / share * axes[k][a] + lens->tangent * of->eye[a];
            most[sign] = extent_along(of->small, slanted).to - lens->tangent * out->depth;
        }
        *sides[k] = (extent){-most[1] * share, most[0] * share};
    }
}

/* depth: of the middle of the picture; NULL: that of what is visible. */
static void find_frame(frame *out, shadow *of, const cvol_coarse *coarse, const cvol_grid *grid,
                       const float *extinction, const perspective *lens, const double *depth)
{
    const extent box[2] = {extent_of_box(grid, of->right), extent_of_box(grid, of->up)};
    extent found[2], along;
    shadow from_side = *of;
    out->is_coarse = 0;
    if (of->small) {
        frame_box(out, of, lens, depth);
        return;
    }
    project(of, coarse, grid, extinction, 0);
    const int any = find_extent(&found[0], of, lens->least, 1) &&
                    find_extent(&found[1], of, lens->least, 0),
              fine = any && are_few_cells(found, coarse, grid, FEW_CELLS);
    if (fine) {
        extent finer[2];
        project(of, coarse, grid, extinction, 1);
        if (find_extent(&finer[0], of, lens->least, 1) &&
            find_extent(&finer[1], of, lens->least, 0))
            memcpy(found, finer, sizeof found);
    }
    out->is_coarse = !any || are_few_cells(found, coarse, grid, UNRESOLVED);
    out->x = any ? found[0] : box[0];
    out->y = any ? found[1] : box[1];
    /* Points are coarse; nothing lies beyond the volume. */
    out->x = (extent){fmax(out->x.from, box[0].from), fmin(out->x.to, box[0].to)};
    out->y = (extent){fmax(out->y.from, box[1].from), fmin(out->y.to, box[1].to)};
    memcpy(from_side.right, of->eye, sizeof from_side.right);
    project(&from_side, coarse, grid, extinction, fine);
    out->depth = depth ? *depth
                 : any && find_extent(&along, &from_side, lens->least, 1)
                     ? (along.from + along.to) / 2
                     : 0;
    if (lens->tangent > 0)
        widen(out, of, coarse, grid, extinction, lens);
}

/* Sets zoom and look_at for pictures with these frames, which have a common middle if they are
 * several. */
static void set_camera(cvol_render_options *options, const shadow *of, const frame *all,
                       double diagonal)
{
    cvol_camera *camera = &options->camera;
    const double width = all->x.to - all->x.from, height = all->y.to - all->y.from;
    const double shape = (double)options->height / options->width;
    const double needed = fmax(fmax(height, width * shape), LEAST_EXTENT * diagonal) /
                          CVOL_FIT_SHARE;
    camera->zoom = diagonal / needed;
    for (int a = 0; a < 3; a++)
        camera->look_at[a] = of->right[a] * (all->x.from + all->x.to) / 2 +
                             of->up[a] * (all->y.from + all->y.to) / 2 + of->eye[a] * all->depth;
}

/* Of one picture. */
static int look_from(cvol_context *context, shadow *out, const cvol_grid *grid,
                     const cvol_render_options *options, double turn)
{
    cvol_render_options at = *options;
    cvol_view view;
    at.camera.azimuth_deg += turn;
    at.camera.placed = 0;
    at.camera.fov_deg = 0;
    at.camera.zoom = 1;
    memset(at.camera.look_at, 0, sizeof at.camera.look_at);
    const int code = cvol_view_make(context, &view, grid, &at);
    memcpy(out->right, view.right, sizeof out->right);
    memcpy(out->up, view.up, sizeof out->up);
    memcpy(out->eye, view.eye, sizeof out->eye);
    return code;
}

/* A turn: the middle is that of the visible part along x, y, z, and the frame holds all pictures
 * about it. */
static int fit_turn(cvol_context *context, cvol_render_options *options, shadow *of,
                    const cvol_coarse *coarse, const cvol_grid *grid, const float *extinction,
                    const perspective *lens, double diagonal, int turns, int *is_coarse)
{
    static const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1};
    const perspective parallel = {.shape = lens->shape, .least = lens->least};
    frame front;
    double half[2] = {0, 0};
    memcpy(of->right, x, sizeof x);
    memcpy(of->up, z, sizeof z);
    memcpy(of->eye, y, sizeof y);
    find_frame(&front, of, coarse, grid, extinction, &parallel, NULL);
    *is_coarse = front.is_coarse;
    const double middle[3] = {(front.x.from + front.x.to) / 2, front.depth,
                              (front.y.from + front.y.to) / 2};
    int code = CVOL_OK;
    for (int k = 0; k < turns && !code; k++) {
        frame one;
        code = look_from(context, of, grid, options, 360.0 * k / turns);
        if (code)
            break;
        const double depth = dot(middle, of->eye);
        find_frame(&one, of, coarse, grid, extinction, lens, &depth);
        const double u = dot(middle, of->right), v = dot(middle, of->up);
        half[0] = fmax(half[0], fmax(one.x.to - u, u - one.x.from));
        half[1] = fmax(half[1], fmax(one.y.to - v, v - one.y.from));
    }
    const frame all = {{-half[0], half[0]}, {-half[1], half[1]}, 0, 0};
    set_camera(options, of, &all, diagonal);
    memcpy(options->camera.look_at, middle, sizeof middle);
    return code;
}

/* size: of what is visible in one picture; NULL: not needed. small: instead of what the cells show,
 * or NULL. *is_coarse: see frame. */
static int fit(cvol_context *context, cvol_render_options *options, double size[2], int *is_coarse,
               const cvol_coarse *coarse, const cvol_grid *grid, const cvol_transfer *transfer,
               int turns, const cvol_small_box *small)
{
    const size_t cells = cvol_coarse_count(coarse), points = (size_t)POINTS * POINTS;
    float *memory = cvol_allocate(cells + points, sizeof *memory);
    if (!memory)
        return cvol_fail_memory(context, (cells + points) * sizeof *memory, "a frame");
    double diagonal = 0, longest = 0; /* of the samples' centres; of what is drawn */
    for (int a = 0; a < 3; a++) {
        diagonal = hypot(diagonal, (double)(grid->dims[a] - 1) * grid->spacing[a]);
        longest = hypot(longest, 2 * half_side(grid, a));
    }
    if (!(diagonal > 0))
        diagonal = (grid->spacing[0] + grid->spacing[1] + grid->spacing[2]) / 3;
    shadow of = {.point = longest / (POINTS - 2),
                 .depths = memory + cells,
                 .small = small,
                 .is_grey = cvol_mode_is_grey(options->mode)};
    const perspective lens = {
        .tangent = size ? 0 : tan(options->camera.fov_deg / 2 * RADIANS_PER_DEGREE),
        .shape = (double)options->height / options->width,
        .least = of.is_grey ? GREY_DEPTH_MIN : DEPTH_MIN};
    frame all;
    int code = small ? CVOL_OK
                     : cvol_extinction_find(context, memory, coarse, grid, transfer, options);
    if (!code && turns > 1)
        code = fit_turn(context, options, &of, coarse, grid, memory, &lens, diagonal, turns,
                        is_coarse);
    else if (!code && !(code = look_from(context, &of, grid, options, 0))) {
        find_frame(&all, &of, coarse, grid, memory, &lens, NULL);
        set_camera(options, &of, &all, diagonal);
        *is_coarse = all.is_coarse;
        if (size) {
            size[0] = fmax(all.x.to - all.x.from, LEAST_EXTENT * diagonal);
            size[1] = fmax(all.y.to - all.y.from, LEAST_EXTENT * diagonal);
        }
    }
    free(memory);
    return code;
}

static int fit_source(cvol_context *context, cvol_render_options *options, double size[2],
                      const cvol_source *source, const cvol_transfer *transfer, int turns)
{
    cvol_source of = {0};
    cvol_coarse coarse = {.values = NULL};
    int code = cvol_options_copy(context, &of, sizeof of, CVOL_SIZE_TO(cvol_source, rho),
                                 "cvol_source", source);
    if (code)
        return code;
    if (!of.array == !of.volume)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a frame needs one array or one volume as its source");
    if (options->mode == CVOL_MODE_COMPOSITE && !transfer)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "a frame in mode composite needs a transfer function");
    if (turns < 1)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "turns is %d, must be 1 or more", turns);
    code = of.array ? cvol_coarse_of_array(context, &coarse, of.array)
                    : cvol_coarse_of_volume(context, &coarse, of.volume, of.mask);
    const cvol_grid *grid = of.array ? cvol_array_grid(of.array) : &of.volume->grid;
    cvol_small_box small;
    int is_coarse = 0, found = 0;
    if (!code)
        code = fit(context, options, size, &is_coarse, &coarse, grid, transfer, turns, NULL);
    if (!code && is_coarse)
        code = cvol_small_box_find(context, &small, &found, &of, transfer, options);
    if (!code && found)
        code = fit(context, options, size, &is_coarse, &coarse, grid, transfer, turns, &small);
    cvol_coarse_free(&coarse);
    return code;
}

int cvol_camera_fit(cvol_context *context, cvol_render_options *options, const cvol_source *source,
                    const cvol_transfer *transfer, int turns)
{
    return fit_source(context, options, NULL, source, transfer, turns);
}

int cvol_camera_fit_extent(cvol_context *context, cvol_render_options *options, double size[2],
                           const cvol_source *source, const cvol_transfer *transfer)
{
    return fit_source(context, options, size, source, transfer, 1);
}

int cvol_render_options_set_look(cvol_context *context, cvol_render_options *options, int *mirrored,
                                 const cvol_source *source, const cvol_transfer *transfer)
{
    const cvol_grid *grid = source->array    ? cvol_array_grid(source->array)
                            : source->volume ? &source->volume->grid
                                             : NULL;
    *mirrored = 0;
    if (grid)
        cvol_camera_set_default(&options->camera, mirrored, grid, 0);
    cvol_render_options_set_studio(options);
    if (*mirrored)
        options->illumination.in_view = -1;
    if (options->mode == CVOL_MODE_COMPOSITE && transfer && cvol_transfer_is_opaque(transfer)) {
        options->shading.on = 0;
        options->illumination = (cvol_illumination){0};
    }
    return cvol_camera_fit(context, options, source, transfer, 1);
}
