/* The geometry of a frame: principal axis, shear, and the grids of slices and intermediate image
 * (Lacroute and Levoy, "Fast Volume Rendering Using a Shear-Warp Factorization of the Viewing
 * Transformation", 1994; parallel projection). */
#include <math.h>

#include "base/context.h"
#include "render/sheet/frame/level.h"
#include "render/sheet/frame/plan.h"
#include "render/view/camera.h"

/* Intermediate pixels beyond the rows of a strip that the warp reads, and one more. */
#define REACH 4
/* Slices around a part at which rays are followed: PART_REACH of the kernels. */
#define PART_AROUND 3

/* The axis along which rays cross the most slices. */
static int find_axis(const double rate[3])
{
    int c = 0;
    for (int a = 1; a < 3; a++)
        if (fabs(rate[a]) > fabs(rate[c]))
            c = a;
    return c;
}

/* From picture pixel to in-plane point at slice 0: follows the ray from the pixel's world point to
 * the plane of that slice. */
static void find_warp(cvol_sheet_plan *plan, const cvol_view *view, const double spacing[3])
{
    const int axes[2] = {plan->axis_lane, plan->axis_row};
    const double shears[2] = {plan->shear_lane, plan->shear_row};
    const int c = plan->axis_sheet;
    for (int k = 0; k < 2; k++) {
        const int a = axes[k];
        double start[2]; /* index coordinates along a and c of the centre of pixel (0, 0) */
        double right[2] = {view->right[a] * view->pixel / spacing[a],
                           view->right[c] * view->pixel / spacing[c]};
        double down[2] = {-view->up[a] * view->pixel / spacing[a],
                          -view->up[c] * view->pixel / spacing[c]};
        double x = 0.5 - 0.5 * view->width, y = 0.5 + view->first_row - 0.5 * view->all_rows;
        start[0] = view->centre[a] / spacing[a] + x * right[0] + y * down[0];
        start[1] = view->centre[c] / spacing[c] + x * right[1] + y * down[1];
        plan->warp[k][0] = start[0] - shears[k] * start[1];
        plan->warp[k][1] = right[0] - shears[k] * right[1];
        plan->warp[k][2] = down[0] - shears[k] * down[1];
    }
}

/* The number of picture pixels per unit of U (k = 0) or V (k = 1). */
static double pixels_per_sample(double warp[][3], int k)
{
    double determinant = warp[0][1] * warp[1][2] - warp[0][2] * warp[1][1];
    return hypot(warp[1 - k][1], warp[1 - k][2]) / fabs(determinant);
}

/* Points per block: fewer than samples if a pixel of the picture spans more than one. */
static void find_points(int *points, double *pitch, double *first, double coarsest, double pixel,
                        int block)
{
    const int less = block < 16 ? 2 : block / 8; /* kernels need an even number of points */
    *points = block;
    while (*points - less >= block / 2 && (double)block / (*points - less) <= coarsest * pixel)
        *points -= less;
    *pitch = (double)block / *points;
    *first = (*pitch - 1) / 2;
}

void cvol_sheet_refine(cvol_sheet_plan *plan, double coarsest)
{
    find_points(&plan->points_lane, &plan->pitch_lane, &plan->first_lane, coarsest,
                1 / pixels_per_sample(plan->warp, 0), plan->block_lane);
    find_points(&plan->points_row, &plan->pitch_row, &plan->first_row, coarsest,
                1 / pixels_per_sample(plan->warp, 1), plan->block_row);
}

/* Points per block, and the distance of intermediate pixels, along one axis. If a pixel of the
 * picture spans less than a sample, the intermediate image is finer than the samples. */
void cvol_sheet_resolution(int *points, double *pitch, double *first, double *delta,
                           const cvol_view *view, double pixel, int block)
{
    find_points(points, pitch, first, view->coarsest, pixel, block);
    *delta = pixel < 1 && *points == block ? fmin(1, view->apart * pixel) : *pitch;
}

/* Returns 1 if pixels of the picture, along one of its axes, lie `delta` apart in U (or V), and
 * along the other not at all. */
static int is_aligned(const double warp[3], double delta)
{
    const double tolerance = 1e-9 * delta;
    return (fabs(fabs(warp[1]) - delta) < tolerance && fabs(warp[2]) < tolerance) ||
           (fabs(fabs(warp[2]) - delta) < tolerance && fabs(warp[1]) < tolerance);
}

/* Widens the range `lo` to `hi` by what rows `first` to `end` of the picture, and one more on each
 * side, cover of U (or V). */
static void cover(double *lo, double *hi, const double warp[3], const cvol_view *view, int first,
                  int end)
{
    for (int corner = 0; corner < 4; corner++) {
        const double x = corner & 1 ? view->width : -1, y = corner & 2 ? end : first - 1;
        const double at = warp[0] + x * warp[1] + y * warp[2];
        *lo = fmin(*lo, at);
        *hi = fmax(*hi, at);
    }
}

/* The range of U (or V) that both the slices and the picture cover, in intermediate pixels. If
 * possible these are the picture's own pixels, so that the warp does not blur them. Some rows of a
 * picture have the intermediate pixels of the whole one. */
static int find_extent(double *start, int *count, double delta, double shear,
                       const cvol_sheet_plan *plan, int k, const double warp[3],
                       const cvol_view *view)
{
    double drift_a = -shear * plan->lo[2], drift_b = -shear * plan->hi[2];
    double lo = fmin(drift_a, drift_b) + plan->lo[k];
    double hi = fmax(drift_a, drift_b) + plan->hi[k];
    double picture_lo = INFINITY, picture_hi = -INFINITY;
    cover(&picture_lo, &picture_hi, warp, view, -view->first_row, view->all_rows - view->first_row);
    double rows_lo = INFINITY, rows_hi = -INFINITY;
    cover(&rows_lo, &rows_hi, warp, view, 0, view->height);
    lo = fmax(lo, picture_lo) - delta;
    hi = fmin(hi, picture_hi) + delta;
    if (is_aligned(warp, delta))
        lo = warp[0] + floor((lo - warp[0]) / delta) * delta;
    if (view->height < view->all_rows) { /* whole groups, as kernels draw them */
        lo += fmax(0, floor(((rows_lo - lo) / delta - REACH) / CVOL_GROUP)) * CVOL_GROUP * delta;
        hi = fmin(hi, rows_hi + REACH * delta);
    }
    double pixels = hi > lo ? ceil((hi - lo) / delta) + 1 : 1;
    *start = lo;
    *count = pixels < CVOL_INTERMEDIATE_MAX ? (int)pixels : CVOL_INTERMEDIATE_MAX + 1;
    return *count <= CVOL_INTERMEDIATE_MAX;
}

/* Samples of an axis of a level, see level.h. */
static void set_level(int *block, int *points, double *pitch, double *first, size_t *blocks,
                      size_t samples, int level)
{
    const size_t size = cvol_sheet_level_size(samples, level);
    *pitch = samples == 1 ? 1 : 1 << level;
    *first = (*pitch - 1) / 2;
    *points = CVOL_LEVEL_BLOCK;
    *block = CVOL_LEVEL_BLOCK * (int)*pitch;
    *blocks = (size + CVOL_LEVEL_BLOCK - 1) / CVOL_LEVEL_BLOCK;
}

/* The distance of pixels of the intermediate image along an axis of a level: that of its samples,
 * so that the warp magnifies them. A volume that is thin along an axis has MIN_SPAN pixels, if
 * the picture has that resolution. */
#define MIN_SPAN 16
static double choose_delta(double pitch, size_t samples, double pixels)
{
    const double span = (double)(samples - 1) + 2 * cvol_sheet_margin(samples);
    return fmin(pitch, fmax(span / MIN_SPAN, 1 / pixels));
}

static void choose_level(cvol_sheet_plan *plan)
{
    const int level = plan->level;
    set_level(&plan->block_lane, &plan->points_lane, &plan->pitch_lane, &plan->first_lane,
              &plan->blocks_lane, plan->lanes, level);
    set_level(&plan->block_row, &plan->points_row, &plan->pitch_row, &plan->first_row,
              &plan->blocks_row, plan->rows, level);
    set_level(&plan->block_sheet, &plan->points_sheet, &plan->pitch_sheet, &plan->first_sheet,
              &plan->layers, plan->sheets, level);
    plan->sheet_count = cvol_sheet_level_size(plan->sheets, level);
    plan->beyond = plan->sheets > 1;
}

/* The volume's own blocks. */
static void set_blocks(cvol_sheet_plan *plan, const cvol_array *array)
{
    plan->blocks_lane = array->blocks[plan->axis_lane];
    plan->blocks_row = array->blocks[plan->axis_row];
    plan->layers = array->blocks[plan->axis_sheet];
    plan->block_lane = plan->block_row = plan->block_sheet = array->block;
    plan->points_sheet = array->block;
    plan->sheet_count = plan->sheets;
    plan->beyond = 0;
    plan->pitch_sheet = 1;
    plan->first_sheet = 0;
}

void cvol_sheet_plan_volume(cvol_sheet_plan *plan, const cvol_array *array, int level,
                            const cvol_view *view, int axis)
{
    const cvol_grid *grid = &array->grid;
    *plan = (cvol_sheet_plan){.axis_sheet = axis,
                              .axis_lane = axis == 0 ? 1 : 0,
                              .axis_row = axis == 2 ? 1 : 2,
                              .level = level,
                              .lapped = array->lapped && !level,
                              .own = {-INFINITY, INFINITY}};
    const int axes[3] = {plan->axis_lane, plan->axis_row, plan->axis_sheet};
    plan->lanes = grid->dims[plan->axis_lane];
    plan->rows = grid->dims[plan->axis_row];
    plan->sheets = grid->dims[plan->axis_sheet];
    if (level)
        choose_level(plan);
    else
        set_blocks(plan, array);
    plan->clipped = view->clipped;
    plan->planes = view->planes;
    for (int k = 0; k < 3; k++) {
        plan->lo[k] = view->lo[axes[k]];
        plan->hi[k] = view->hi[axes[k]];
        plan->used_lo[k] = plan->lo[k];
        plan->used_hi[k] = plan->hi[k];
        plan->spacing[k] = grid->spacing[axes[k]] / view->mean_spacing;
        for (int i = 0; i < view->planes; i++)
            plan->plane[i][k] = view->plane[i][axes[k]];
    }
    for (int i = 0; i < view->planes; i++)
        plan->plane[i][3] = view->plane[i][3];
    plan->fades = view->cuts;
    for (int i = 0; i < view->cuts; i++) {
        for (int k = 0; k < 3; k++)
            plan->fade[i][k] = view->cut[i][axes[k]];
        plan->fade[i][3] = view->cut[i][3];
    }
}

/* Places on a plane belong to the part above it. */
#define BELOW 1e-9

/* Adds the plane at `at` of an axis; above: what lies above it is drawn. */
static void add_face(cvol_sheet_plan *plan, int k, double at, int above)
{
    double *plane = plan->plane[plan->planes++];
    for (int i = 0; i < 4; i++)
        plane[i] = 0;
    plane[k] = above ? 1 : -1;
    plane[3] = above ? -at : at - BELOW;
    plan->part_planes++;
}

void cvol_sheet_plan_narrow(cvol_sheet_plan *plan, const cvol_view *view, cvol_mode mode)
{
    const int axes[3] = {plan->axis_lane, plan->axis_row, plan->axis_sheet};
    const int by_planes = !cvol_mode_is_grey(mode);
    const double around = by_planes ? PART_AROUND * plan->pitch_sheet : 0;
    for (int k = 0; k < 3; k++) {
        const double lo = view->own_lo[axes[k]], hi = view->own_hi[axes[k]];
        const int above = lo > plan->lo[k], below = hi < plan->hi[k];
        plan->used_lo[k] = fmax(plan->lo[k], lo - around);
        plan->used_hi[k] = fmin(plan->hi[k], hi + around);
        if (!by_planes) {
            plan->lo[k] = plan->used_lo[k];
            plan->hi[k] = plan->used_hi[k];
            continue;
        }
        if (above)
            add_face(plan, k, lo, 1);
        if (below)
            add_face(plan, k, hi, 0);
    }
}

/* Returns 1 if there may be fewer slices than samples: faces of lapped arrays need two. */
static int may_have_fewer(const cvol_sheet_plan *plan)
{
    const size_t in_last = plan->sheets % (size_t)plan->block_sheet;
    return !plan->level && plan->sheets > 1 && !(plan->lapped && in_last == 2);
}

void cvol_sheet_plan_halve(cvol_sheet_plan *plan)
{
    if (!may_have_fewer(plan))
        return;
    plan->points_sheet = plan->block_sheet / 2;
    plan->pitch_sheet = 2;
    plan->first_sheet = 0.5;
    plan->sheet_count = (plan->sheets + 1) / 2;
    plan->beyond = 1;
}

void cvol_sheet_plan_limit(cvol_sheet_plan *plan, double farthest)
{
    plan->du = fmin(plan->du, plan->pitch_lane / farthest);
    plan->dv = fmin(plan->dv, plan->pitch_row / farthest);
}

int cvol_sheet_plan_make(cvol_context *context, cvol_sheet_plan *plan, const cvol_array *array,
                         int level, const cvol_view *view)
{
    const cvol_grid *grid = &array->grid;
    double rate[3]; /* sample indices per world length along a ray */
    for (int a = 0; a < 3; a++)
        rate[a] = -view->eye[a] / grid->spacing[a];
    const int c = find_axis(rate);
    cvol_sheet_plan_volume(plan, array, level, view, c);
    plan->ascending = rate[c] > 0;
    plan->shear_lane = rate[plan->axis_lane] / rate[c];
    plan->shear_row = rate[plan->axis_row] / rate[c];
    plan->warp[2][0] = 1;
    if (view->step >= 2 / fabs(rate[c]) / view->mean_spacing)
        cvol_sheet_plan_halve(plan);
    plan->distance = plan->pitch_sheet / fabs(rate[plan->axis_sheet]) / view->mean_spacing;
    find_warp(plan, view, grid->spacing);
    const double pixels[2] = {view->rays * pixels_per_sample(plan->warp, 0),
                              view->rays * pixels_per_sample(plan->warp, 1)};
    if (level) {
        plan->du = choose_delta(plan->pitch_lane, plan->lanes, pixels[0]) / view->rays;
        plan->dv = choose_delta(plan->pitch_row, plan->rows, pixels[1]) / view->rays;
    } else {
        cvol_sheet_resolution(&plan->points_lane, &plan->pitch_lane, &plan->first_lane, &plan->du,
                              view, 1 / pixels[0], array->block);
        cvol_sheet_resolution(&plan->points_row, &plan->pitch_row, &plan->first_row, &plan->dv,
                              view, 1 / pixels[1], array->block);
    }
    cvol_sheet_plan_limit(plan, 1);
    if (!find_extent(&plan->u0, &plan->width, plan->du, plan->shear_lane, plan, 0, plan->warp[0],
                     view) ||
        !find_extent(&plan->v0, &plan->height, plan->dv, plan->shear_row, plan, 1, plan->warp[1],
                     view))
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "a picture of %d x %d needs an intermediate image of more than %d pixels "
                         "along an axis",
                         view->width, view->height, CVOL_INTERMEDIATE_MAX);
    plan->width = (plan->width + CVOL_GROUP - 1) / CVOL_GROUP * CVOL_GROUP;
    return CVOL_OK;
}
