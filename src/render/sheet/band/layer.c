/* The description of a layer for the line kernels: where rays cross its slices, how far these
 * reach, and the rows of blocks that some lines meet. Lacroute and Levoy 1994: slices are sheared,
 * and in perspective scaled. */
#include <math.h>
#include <string.h>

#include "render/sheet/band/layer.h"

#include "render/sheet/band/intermediate.h"

/* The row that line V crosses; next to the eye and behind it, the eye's own. */
static double find_row(const cvol_sheet_plan *plan, const cvol_sheet_crossing *at, double V)
{
    return at->scale > 0 ? at->row + at->scale * V : plan->eye_row;
}

/* The rows lo .. hi that the rays of some lines cross within the volume's lanes, between two planes
 * of samples. Pixels, lines and planes are a box, in which lane and row are linear. The row has its
 * extremes at the box's corners, and where its edges cross the first and the last lane. */
static void find_rows_image_order(double *lo, double *hi, const cvol_sheet_plan *plan,
                                  const double z[2], int line_begin, int line_end)
{
    const double i[2] = {0, plan->width - 1}, j[2] = {line_begin, line_end - 1};
    const double ends[2] = {plan->lo[0] - 2, plan->hi[0] + 2};
    double lane[8], row[8];
    for (int k = 0; k < 8; k++) {
        const double x = i[k & 1], y = j[k >> 1 & 1], depth = z[k >> 2];
        const double *u = plan->place[0], *v = plan->place[1];
        lane[k] = u[0] + x * u[1] + y * u[2] + plan->shear_lane * depth;
        row[k] = v[0] + x * v[1] + y * v[2] + plan->shear_row * depth;
        if (lane[k] >= ends[0] && lane[k] <= ends[1]) {
            *lo = fmin(*lo, row[k]);
            *hi = fmax(*hi, row[k]);
        }
    }
    for (int k = 0; k < 8; k++)
        for (int axis = 1; axis < 8; axis *= 2)
            for (int end = 0; end < 2 && !(k & axis); end++) {
                const int other = k | axis;
                const double from = lane[k] - ends[end], to = lane[other] - ends[end];
                if ((from < 0) == (to < 0))
                    continue;
                const double at = row[k] + (row[other] - row[k]) * (from / (from - to));
                *lo = fmin(*lo, at);
                *hi = fmax(*hi, at);
            }
}

int cvol_layer_rows(size_t *first, size_t *last, const cvol_sheet_plan *plan, size_t layer,
                    int line_begin, int line_end)
{
    size_t z_begin, z_end;
    cvol_layer_sheets(&z_begin, &z_end, plan, layer);
    const double around = plan->lapped ? 2 : 0; /* rows and slices that faces mix */
    /* Samples between slices, and midpoints, use a slice when rays are up to one slice before or
     * behind it; light does, too. Only lines of the intermediate image are never further than
     * `reach` there. */
    const int between = plan->parts > 1 || plan->image_order;
    const double behind = (around + plan->beyond + between) * plan->pitch_sheet;
    const cvol_sheet_crossing from = cvol_sheet_cross(plan,
                                                      cvol_sheet_place(plan, z_begin) - behind),
                              to = cvol_sheet_cross(plan,
                                                    cvol_sheet_place(plan, z_end - 1) + behind);
    if (from.scale <= 0 && to.scale <= 0) /* behind the eye */
        return 0;
    const double top = plan->v0 + line_begin * plan->dv,
                 reach = (1 + around + plan->reach) * plan->pitch_row,
                 bottom = plan->v0 + (line_end - 1) * plan->dv;
    double lo = fmin(find_row(plan, &from, top), find_row(plan, &to, top)) - reach;
    double hi = fmax(find_row(plan, &from, bottom), find_row(plan, &to, bottom)) + reach;
    if (plan->image_order) {
        lo = INFINITY;
        hi = -INFINITY;
        const double planes[2] = {cvol_sheet_place(plan, z_begin) - behind,
                                  cvol_sheet_place(plan, z_end - 1) + behind};
        find_rows_image_order(&lo, &hi, plan, planes, line_begin, line_end);
        if (!(lo <= hi)) /* outside the volume */
            return 0;
        lo -= reach;
        hi += reach;
    }
    const double rows = (double)(plan->rows - 1);
    const double beyond = fmax(2, 2 * plan->pitch_sheet) + plan->reach * fmax(1, plan->pitch_row);
    if (hi < -beyond ||
        lo > rows + beyond) /* rays may enter or leave between this slice and the next */
        return 0;
    *first = (size_t)fmin(fmax(lo, 0), rows) / (size_t)plan->block_row;
    *last = (size_t)fmin(fmax(hi, 0), rows) / (size_t)plan->block_row;
    return 1;
}

static int clamp_group(double group, int groups)
{
    return group < 0 ? 0 : group > groups ? groups : (int)group;
}

/* The pixels [0] .. [1] whose rays are within lanes lo .. hi on a plane of samples; none on a plane
 * behind the eye. */
static void find_pixels(double pixels[2], const cvol_layer *layer, const cvol_sheet_plan *plan,
                        double z)
{
    const cvol_sheet_crossing at = cvol_sheet_cross(plan, z);
    pixels[0] = INFINITY;
    pixels[1] = -INFINITY;
    if (!(at.scale > 0))
        return;
    const double start = (at.lane + at.scale * plan->u0 - plan->first_lane) / plan->pitch_lane,
                 step = at.scale * plan->du / plan->pitch_lane;
    pixels[0] = (layer->lane_lo - start) / step;
    pixels[1] = (layer->lane_hi - start) / step;
}

/* Finds the groups that meet the slice at z, see cvol_sheet_view; `next` leads to the next one. */
static void find_groups(cvol_sheet_view *sheet, const cvol_layer *layer,
                        const cvol_sheet_plan *plan, double z, double next)
{
    const int groups = plan->width / CVOL_GROUP;
    sheet->begin = sheet->end = sheet->inside_begin = sheet->inside_end = 0;
    if (!(cvol_sheet_cross(plan, z).scale > 0))
        return;
    double most[2] = {INFINITY, -INFINITY}, least[2] = {-INFINITY, INFINITY};
    for (int k = -2; k <= 1; k++) {
        double pixels[2];
        find_pixels(pixels, layer, plan, z + k * next);
        if (k > -2 && pixels[0] <= pixels[1]) {
            most[0] = fmin(most[0], pixels[0]);
            most[1] = fmax(most[1], pixels[1]);
        }
        least[0] = fmax(least[0], pixels[0]);
        least[1] = fmin(least[1], pixels[1]);
    }
    sheet->begin = clamp_group(floor(ceil(most[0]) / CVOL_GROUP), groups);
    sheet->end = clamp_group(floor(floor(most[1]) / CVOL_GROUP) + 1, groups);
    sheet->inside_begin = clamp_group(ceil(least[0] / CVOL_GROUP), groups);
    sheet->inside_end = clamp_group(floor((floor(least[1]) + 1) / CVOL_GROUP), groups);
}

/* The faces of one axis, see cvol_layer; rays move by `shear` per slice. */
static void find_faces(double *enter, double *leave, float *is_perspective, double lo, double hi,
                       double pitch, double shear)
{
    const double least_shear = 1e-5;
    *enter = shear < 0 ? hi : lo;
    *leave = shear < 0 ? lo : hi;
    *is_perspective = (float)((shear < 0 ? -1 : 1) / fmax(fabs(shear) / pitch, least_shear));
}

/* A linear function n of places as one of pixels, for the slice at z. */
static void describe_plane_image_order(cvol_sheet_linear *cut, const cvol_sheet_plan *plan,
                                       const double n[4], double z, double next)
{
    const double *u = plan->place[0], *v = plan->place[1];
    for (int k = 0; k < 3; k++) {
        cut->value[k] = n[0] * u[k] + n[1] * v[k];
        cut->rate[k] = 0;
    }
    cut->rate[0] = (n[0] * plan->shear_lane + n[1] * plan->shear_row + n[2]) * next;
    cut->value[0] += cut->rate[0] * z / next + n[3];
}

/* The same in object order. */
static void describe_plane(cvol_sheet_linear *cut, const cvol_sheet_plan *plan, const double n[4],
                           double z, double next)
{
    const cvol_sheet_crossing at = cvol_sheet_cross(plan, z),
                              then = cvol_sheet_cross(plan, z + next);
    double value[2][3];
    for (int k = 0; k < 2; k++) {
        const cvol_sheet_crossing *c = k ? &then : &at;
        value[k][0] = n[0] * (c->lane + c->scale * plan->u0) +
                      n[1] * (c->row + c->scale * plan->v0) + n[2] * (k ? z + next : z) + n[3];
        value[k][1] = n[0] * c->scale * plan->du;
        value[k][2] = n[1] * c->scale * plan->dv;
    }
    for (int k = 0; k < 3; k++) {
        cut->value[k] = value[0][k];
        cut->rate[k] = value[1][k] - value[0][k];
    }
}

/* The same for image-order plans. */
static void describe_sheet_image_order(cvol_sheet_view *sheet, const cvol_sheet_plan *plan,
                                       double z, double next)
{
    const double *u = plan->place[0], *v = plan->place[1];
    sheet->lane_at = (u[0] + plan->shear_lane * z - plan->first_lane) / plan->pitch_lane;
    sheet->lane_step = u[1] / plan->pitch_lane;
    sheet->lane_down = u[2] / plan->pitch_lane;
    sheet->row_at = (v[0] + plan->shear_row * z - plan->first_row) / plan->pitch_row;
    sheet->row_right = v[1] / plan->pitch_row;
    sheet->row_step = v[2] / plan->pitch_row;
    sheet->lane_rate[0] = plan->shear_lane * next / plan->pitch_lane;
    sheet->row_rate[0] = plan->shear_row * next / plan->pitch_row;
    sheet->lane_rate[1] = sheet->row_rate[1] = 0;
    sheet->begin = sheet->end = sheet->inside_begin = sheet->inside_end = 0; /* of each line */
    for (int i = 0; i < plan->planes; i++)
        describe_plane_image_order(&sheet->cuts[i], plan, plan->plane[i], z, next);
}

/* Describes the positions of the slice's samples, and the planes that cut it. */
static void describe_sheet(cvol_sheet_view *sheet, const cvol_sheet_plan *plan, double z,
                           double next)
{
    const cvol_sheet_crossing at = cvol_sheet_cross(plan, z);
    sheet->lane_at = (at.lane + at.scale * plan->u0 - plan->first_lane) / plan->pitch_lane;
    sheet->row_at = (at.row + at.scale * plan->v0 - plan->first_row) / plan->pitch_row;
    sheet->lane_step = at.scale * plan->du / plan->pitch_lane;
    sheet->row_step = at.scale * plan->dv / plan->pitch_row;
    const double is_perspective = plan->perspective ? 1 : 0, way = plan->ascending ? 1 : -1;
    const double lane = is_perspective > 0 ? plan->u0 - plan->eye_lane : way * plan->shear_lane,
                 row = is_perspective > 0 ? plan->v0 - plan->eye_row : way * plan->shear_row;
    sheet->lane_rate[0] = lane * plan->pitch_sheet / plan->pitch_lane;
    sheet->row_rate[0] = row * plan->pitch_sheet / plan->pitch_row;
    sheet->lane_rate[1] = is_perspective * plan->du * plan->pitch_sheet / plan->pitch_lane;
    sheet->row_rate[1] = is_perspective * plan->dv * plan->pitch_sheet / plan->pitch_row;
    for (int i = 0; i < plan->planes; i++)
        describe_plane(&sheet->cuts[i], plan, plan->plane[i], z, next);
}

/* Faces, and the lengths of ray intervals. */
static void describe_rays(cvol_layer *out, const cvol_sheet_plan *plan)
{
    const double tolerance = 1e-4, way = plan->ascending ? 1 : -1;
    out->perspective = plan->perspective;
    out->unit = !plan->perspective && plan->du / plan->pitch_lane == 1;
    out->only = plan->sheets == 1;
    out->parts = plan->parts;
    out->wide = plan->wide;
    out->reach = plan->wide ? plan->reach : 0;
    out->cuts = plan->planes;
    out->part_cuts = plan->part_planes;
    out->lane_lo = (plan->lo[0] - plan->first_lane) / plan->pitch_lane - tolerance;
    out->lane_hi = (plan->hi[0] - plan->first_lane) / plan->pitch_lane + tolerance;
    out->row_lo = (plan->lo[1] - plan->first_row) / plan->pitch_row - tolerance;
    out->row_hi = (plan->hi[1] - plan->first_row) / plan->pitch_row + tolerance;
    find_faces(&out->lane_enter, &out->lane_leave, &out->lane_slices, out->lane_lo, out->lane_hi,
               plan->pitch_lane, way * plan->shear_lane * plan->pitch_sheet);
    find_faces(&out->row_enter, &out->row_leave, &out->row_slices, out->row_lo, out->row_hi,
               plan->pitch_row, way * plan->shear_row * plan->pitch_sheet);
    const double whole = plan->distance / plan->pitch_sheet;
    out->length = plan->spacing[2] * plan->spacing[2] / (whole * whole);
    out->length_lane[0] = (plan->u0 - plan->eye_lane) * plan->spacing[0] / whole;
    out->length_lane[1] = plan->du * plan->spacing[0] / whole;
    out->length_row[0] = (plan->v0 - plan->eye_row) * plan->spacing[1] / whole;
    out->length_row[1] = plan->dv * plan->spacing[1] / whole;
}

/* The depths behind faces of the clip, at a layer's first slice. */
static void describe_fades(cvol_layer *out, const cvol_sheet_plan *plan, double z, double next)
{
    out->fades = plan->fades;
    for (int i = 0; i < plan->fades; i++)
        (plan->image_order ? describe_plane_image_order : describe_plane)(&out->fade[i], plan,
                                                                          plan->fade[i], z, next);
}

static cvol_windows windows_of(const cvol_layer_skip *skip, const cvol_sheet_plan *plan)
{
    return (cvol_windows){.within = skip->within,
                          .across = skip->across,
                          .within_level = skip->levels,
                          .across_level = skip->levels + plan->blocks_row * (size_t)skip->windows,
                          .count = skip->windows,
                          .first_row = (int)skip->first_row,
                          .last_row = (int)skip->last_row,
                          .spread_at = (int)(2 * plan->blocks_row * (size_t)skip->windows)};
}

void cvol_layer_describe(cvol_layer *out, const void *samples, ptrdiff_t row_stride,
                         ptrdiff_t sheet_stride, const cvol_layer_skip *skip,
                         const cvol_layer_skip *before, const cvol_sheet_plan *plan,
                         const cvol_band_layer *at)
{
    const int count = (int)(at->z_end - at->z_begin);
    const int is_last = plan->ascending ? at->layer + 1 == plan->layers : at->layer == 0;
    out->sheet_count = count + (is_last && plan->beyond);
    out->row_stride = row_stride;
    out->int16 = plan->int16;
    out->cover_at = 0;
    describe_rays(out, plan);
    out->row_points = plan->points_row;
    out->row_points_inverse = ((UINT64_C(1) << 32) - 1) / (uint64_t)plan->points_row + 1;
    out->block_rows = (int)plan->blocks_row;
    out->from_row = (int)at->first_row * plan->points_row - 1;
    out->to_row = (int)(at->last_row + 1) * plan->points_row;
    out->from_lane = -CVOL_SHEET_PAD;
    out->to_lane = (int)plan->blocks_lane * plan->points_lane + CVOL_SHEET_PAD - 1;
    out->windows = windows_of(skip, plan);
    out->windows_before = before ? windows_of(before, plan) : (cvol_windows){0};
    /* Row 0 of the samples lies before the buffer if the band does not reach it; kernels touch only
     * rows that the band's lines meet. */
    const ptrdiff_t row_0 = 1 - (ptrdiff_t)at->first_row * plan->points_row;
    const double next = plan->ascending ? plan->pitch_sheet : -plan->pitch_sheet;
    for (int s = 0; s < out->sheet_count; s++) {
        const int of = s < count ? s : count - 1;
        const ptrdiff_t slice = plan->ascending ? of : count - 1 - of;
        const size_t number = at->z_begin + (size_t)slice;
        const double z = cvol_sheet_place(plan, number) + (s - of) * next;
        cvol_sheet_view *sheet = &out->sheets[s];
        sheet->ordinal = (int)(plan->ascending ? number : plan->sheet_count - 1 - number) + s - of;
        const double below = (z - plan->lo[2]) / plan->pitch_sheet,
                     above = (plan->hi[2] - z) / plan->pitch_sheet;
        sheet->front = (float)-(plan->ascending ? below : above);
        sheet->back = (float)(plan->ascending ? above : below);
        sheet->is_first = s == 0;
        sheet->is_of_previous_layer = 0;
        sheet->samples = plan->int16.scale > 0 ? NULL : samples;
        sheet->int16 = plan->int16.scale > 0 ? samples : NULL;
        sheet->first = CVOL_SHEET_PAD + row_0 * row_stride + slice * sheet_stride;
        if (s == 0)
            describe_fades(out, plan, z, next);
        if (plan->image_order) {
            describe_sheet_image_order(sheet, plan, z, next);
            continue;
        }
        describe_sheet(sheet, plan, z, next);
        find_groups(sheet, out, plan, z, next);
    }
}

void cvol_layer_describe_end(cvol_layer *out, const cvol_sheet_plan *plan)
{
    const double next = plan->ascending ? plan->pitch_sheet : -plan->pitch_sheet;
    const int ordinal = (int)plan->sheet_count + plan->beyond;
    const double z = plan->first_sheet +
                     (plan->ascending ? 0 : (double)(plan->sheet_count - 1) * plan->pitch_sheet) +
                     ordinal * next;
    memset(out, 0, sizeof *out);
    if (plan->image_order)
        describe_sheet_image_order(&out->sheets[0], plan, z, next);
    else
        describe_sheet(&out->sheets[0], plan, z, next);
    describe_fades(out, plan, z, next);
    out->sheets[0].ordinal = ordinal;
}
