/* The geometry of a frame in perspective (Lacroute and Levoy 1994, section 3: shift and scale of
 * each slice).
 *
 * With the eye at e, in samples, pixel (x, y) of the picture looks along d(x, y) = d0 + x dx + y
 * dy. Along axis c it is drawn by the plan whose axis has the largest |d_c|, so that no ray meets
 * slices at less than 45 degrees (in samples). These pixels are a convex polygon of the picture,
 * the part of it with d_c >= |d_a| for the two others. The intermediate image lies one sample
 * before the eye: U = e_u + d_u / |d_c|. Its pixels are as fine as the finest pixel of the polygon,
 * which is at one of its corners, since they are images of the picture's pixels under a projective
 * map; and nowhere further apart than samples. */
#include <math.h>

#include "base/context.h"
#include "render/sheet/frame/plan.h"

/* Parts nearer to the eye along the axis are ignored, in samples. */
#define MIN_AHEAD 1e-3

/* ---- the part of the picture along the axis -------------------------------------------------- */

#define CORNERS_MAX 12

typedef struct polygon {
    double at[CORNERS_MAX][2];
    int count;
} polygon;

/* Keeps the part with n . (1, x, y) >= 0 (Sutherland and Hodgman 1974). */
static void cut_polygon(polygon *p, const double n[3])
{
    polygon out = {.count = 0};
    for (int i = 0; i < p->count; i++) {
        const double *a = p->at[i], *b = p->at[(i + 1) % p->count];
        const double f = n[0] + n[1] * a[0] + n[2] * a[1], g = n[0] + n[1] * b[0] + n[2] * b[1];
        if (f >= 0 && out.count < CORNERS_MAX) {
            out.at[out.count][0] = a[0];
            out.at[out.count++][1] = a[1];
        }
        if ((f < 0) != (g < 0) && out.count < CORNERS_MAX) {
            const double t = f / (f - g);
            out.at[out.count][0] = a[0] + t * (b[0] - a[0]);
            out.at[out.count++][1] = a[1] + t * (b[1] - a[1]);
        }
    }
    *p = out;
}

/* The pixels of a plan: the picture, extended by half a pixel. */
static polygon find_polygon(const cvol_sheet_plan *plan, const cvol_view *view)
{
    const double right = view->width - 0.5, below = view->height - 0.5;
    polygon p = {{{-0.5, -0.5}, {right, -0.5}, {right, below}, {-0.5, below}}, 4};
    for (int side = 0; side < 4; side++) {
        double n[3];
        for (int k = 0; k < 3; k++)
            n[k] = plan->warp[2][k] + (side % 2 ? 1 : -1) * plan->warp[side / 2][k];
        cut_polygon(&p, n);
    }
    return p;
}

/* ---- the intermediate image ------------------------------------------------------------------ */

/* The direction of a place in the picture, divided by the movement per slice; 0 if it points
 * backwards. */
static int find_slope(double slope[2], const cvol_sheet_plan *plan, const double at[2])
{
    double d[3];
    for (int k = 0; k < 3; k++)
        d[k] = plan->warp[k][0] + at[0] * plan->warp[k][1] + at[1] * plan->warp[k][2];
    slope[0] = d[0] / d[2];
    slope[1] = d[1] / d[2];
    return d[2] > 0;
}

/* The distance of picture pixels in U and V, at a place of the picture. */
static void find_pixel(double pixel[2], const cvol_sheet_plan *plan, const double at[2])
{
    double slope[2], d = plan->warp[2][0] + at[0] * plan->warp[2][1] + at[1] * plan->warp[2][2];
    double map[2][2];
    find_slope(slope, plan, at);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 2; i++)
            map[k][i] = (plan->warp[k][1 + i] - slope[k] * plan->warp[2][1 + i]) / d;
    const double determinant = fabs(map[0][0] * map[1][1] - map[0][1] * map[1][0]);
    for (int k = 0; k < 2; k++)
        pixel[k] = determinant / hypot(map[1 - k][0], map[1 - k][1]);
}

/* The slopes at which the drawn part is seen, `near` to `far` samples before the eye. */
static void find_visible_slopes(double range[2], const cvol_sheet_plan *plan, int k, double near,
                                double far)
{
    const double eye = k ? plan->eye_row : plan->eye_lane;
    const double lo = plan->lo[k] - eye, hi = plan->hi[k] - eye;
    range[0] = fmin(lo / near, lo / far);
    range[1] = fmax(hi / near, hi / far);
}

static int count_pixels(int *count, double lo, double hi, double delta)
{
    const double pixels = ceil((hi - lo) / delta) + 1;
    *count = pixels < CVOL_INTERMEDIATE_MAX ? (int)pixels : CVOL_INTERMEDIATE_MAX + 1;
    return *count <= CVOL_INTERMEDIATE_MAX;
}

/* The distance before the eye of the last slice that a ray meets: up to one behind the face of a
 * clip, but none behind the last of the volume. */
static double find_farthest(const cvol_sheet_plan *plan, double far)
{
    const double beyond = plan->beyond ? plan->pitch_sheet : 0;
    const double last = cvol_sheet_place(plan, plan->sheet_count - 1) + beyond - plan->eye_sheet,
                 first = cvol_sheet_place(plan, 0) - beyond - plan->eye_sheet;
    return fmin(plan->ascending ? last : -first, far + plan->pitch_sheet);
}

/* Resolution, extent and the longest interval. */
static int plan_image(cvol_sheet_plan *plan, const polygon *p, int block, const cvol_view *view,
                      double near, double far, int *empty)
{
    const double rays = view->rays;
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY},
           pixel[2] = {INFINITY, INFINITY};
    for (int i = 0; i < p->count; i++) {
        double slope[2], here[2];
        if (!find_slope(slope, plan, p->at[i]))
            continue;
        find_pixel(here, plan, p->at[i]);
        double length = plan->spacing[2] * plan->spacing[2];
        for (int k = 0; k < 2; k++) {
            lo[k] = fmin(lo[k], slope[k]);
            hi[k] = fmax(hi[k], slope[k]);
            pixel[k] = fmin(pixel[k], here[k] / rays);
            length += pow(plan->spacing[k] * slope[k], 2);
        }
        plan->distance = fmax(plan->distance, plan->pitch_sheet * sqrt(length));
    }
    if (!plan->level) {
        cvol_sheet_resolution(&plan->points_lane, &plan->pitch_lane, &plan->first_lane, &plan->du,
                              view, pixel[0] * near, block);
        cvol_sheet_resolution(&plan->points_row, &plan->pitch_row, &plan->first_row, &plan->dv,
                              view, pixel[1] * near, block);
    }
    plan->du = fmin(pixel[0], plan->pitch_lane / far / rays);
    plan->dv = fmin(pixel[1], plan->pitch_row / far / rays);
    cvol_sheet_plan_limit(plan, find_farthest(plan, far));
    const double delta[2] = {plan->du, plan->dv};
    for (int k = 0; k < 2; k++) {
        double slopes[2];
        find_visible_slopes(slopes, plan, k, near, far);
        lo[k] = fmax(lo[k], slopes[0]) - 3 * delta[k]; /* the warp's reach, and one */
        hi[k] = fmin(hi[k], slopes[1]) + 3 * delta[k];
        *empty |= !(lo[k] < hi[k]);
    }
    if (*empty)
        return 1;
    plan->u0 = plan->eye_lane + lo[0];
    plan->v0 = plan->eye_row + lo[1];
    const int fits = count_pixels(&plan->width, lo[0], hi[0], plan->du);
    return count_pixels(&plan->height, lo[1], hi[1], plan->dv) && fits;
}

int cvol_sheet_plan_make_along(cvol_context *context, cvol_sheet_plan *plan, int *empty,
                               const cvol_array *array, int level, const cvol_view *view, int along)
{
    const double *spacing = array->grid.spacing;
    *empty = 0;
    cvol_sheet_plan_volume(plan, array, level, view, along / 2);
    plan->perspective = 1;
    plan->ascending = along % 2;
    const int axes[3] = {plan->axis_lane, plan->axis_row, plan->axis_sheet};
    for (int k = 0; k < 3; k++) {
        const int a = axes[k];
        const double sign = k == 2 && !plan->ascending ? -1 : 1, scale = sign / spacing[a];
        const double x = 0.5 - 0.5 * view->width, y = 0.5 + view->first_row - 0.5 * view->all_rows;
        const double right = view->right[a] * view->pixel, down = -view->up[a] * view->pixel;
        const double ahead = view->centre[a] - view->place[a];
        plan->warp[k][0] = (ahead + x * right + y * down) * scale;
        plan->warp[k][1] = right * scale;
        plan->warp[k][2] = down * scale;
    }
    plan->eye_lane = view->place[plan->axis_lane] / spacing[plan->axis_lane];
    plan->eye_row = view->place[plan->axis_row] / spacing[plan->axis_row];
    plan->eye_sheet = view->place[plan->axis_sheet] / spacing[plan->axis_sheet];
    /* The drawn part ahead of the eye. */
    const double from = plan->lo[2] - plan->eye_sheet, to = plan->hi[2] - plan->eye_sheet;
    const double near = fmax(plan->ascending ? from : -to, MIN_AHEAD),
                 far = plan->ascending ? to : -from;
    const polygon p = find_polygon(plan, view);
    *empty = p.count == 0 || far <= near;
    if (*empty)
        return CVOL_OK;
    const double longest = sqrt(3); /* of a ray from slice to slice, over their distance */
    if (view->step >= 2 * longest * plan->spacing[2])
        cvol_sheet_plan_halve(plan);
    if (!plan_image(plan, &p, array->block, view, near, far, empty))
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "a picture of %d x %d needs an intermediate image of more than %d pixels "
                         "along an axis",
                         view->width, view->height, CVOL_INTERMEDIATE_MAX);
    plan->width = (plan->width + CVOL_GROUP - 1) / CVOL_GROUP * CVOL_GROUP;
    return CVOL_OK;
}
