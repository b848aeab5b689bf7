/* Colours of labels in a picture of their shape (cvol/look.h).
 *
 * The ray of a pixel reaches half of its opacity at its depth. The pixel gets the colour of the
 * label that has the largest part of the interpolated samples there: between the eight samples
 * around a place, each label has the sum of the weights of its samples. At the edge of the shape
 * and where it is thin, rays do not reach half: they get the colour of the place along the ray
 * where labels have the largest part. */
#include <math.h>
#include <stdint.h>

#include "base/context.h"
#include "cvol/look.h"
#include "render/view/camera.h"
#include "render/view/view_ray.h"

/* Steps along a ray, in samples. */
#define STEP 0.5

/* The label with the largest part at a place in samples, and that part of all labels there; 0 if
 * none is near. */
static int label_at(double *all, const cvol_volume *labels, const double place[3])
{
    const size_t *n = labels->grid.dims;
    const uint8_t *samples = labels->data;
    size_t low[3], high[3];
    double part[3], weights[8], best = 0;
    int found[8], differs = 0, label = 0;
    for (int a = 0; a < 3; a++) {
        const double at = fmin(fmax(place[a], 0), (double)(n[a] - 1));
        low[a] = (size_t)at;
        high[a] = low[a] + 1 < n[a] ? low[a] + 1 : low[a];
        part[a] = at - (double)low[a];
    }
    *all = 0;
    for (int k = 0; k < 8; k++) {
        const size_t x = k & 1 ? high[0] : low[0], y = k & 2 ? high[1] : low[1],
                     z = k & 4 ? high[2] : low[2];
        found[k] = samples[x + n[0] * (y + n[1] * z)];
        differs |= found[k] ^ found[0];
    }
    if (!differs) {
        *all = found[0] ? 1 : 0;
        return found[0];
    }
    for (int k = 0; k < 8; k++) {
        weights[k] = 1e-9; /* at a sample, its neighbours count a little */
        weights[k] += (k & 1 ? part[0] : 1 - part[0]) * (k & 2 ? part[1] : 1 - part[1]) *
                      (k & 4 ? part[2] : 1 - part[2]);
        *all += found[k] ? weights[k] : 0;
    }
    for (int k = 0; k < 8; k++) {
        double sum = 0;
        for (int other = 0; other < 8; other++)
            sum += found[other] == found[k] ? weights[other] : 0;
        if (found[k] && sum > best) {
            best = sum;
            label = found[k];
        }
    }
    return label;
}

static int label_of_place(double *all, const cvol_volume *labels, const cvol_view_ray *ray,
                          double along)
{
    double place[3];
    for (int a = 0; a < 3; a++)
        place[a] = ray->start[a] + along * ray->direction[a];
    return label_at(all, labels, place);
}

/* The label where labels have the largest part along a ray. */
static int label_of_ray(const cvol_volume *labels, const cvol_view_ray *ray, double step)
{
    double most = 0;
    int label = 0;
    for (double along = ray->near; along <= ray->far && most < 0.5; along += step) {
        double all;
        const int here = label_of_place(&all, labels, ray, along);
        if (here && all > most) {
            most = all;
            label = here;
        }
    }
    return label;
}

/* The rays of a row of a picture in parallel projection: they differ in where they start. */
typedef struct row_rays {
    cvol_view_ray first;
    double next[3]; /* from the start of one to that of the next */
} row_rays;

static row_rays make_row(const cvol_view *view, const double spacing[3], int j)
{
    row_rays row;
    cvol_view_ray second;
    cvol_view_ray_make(&row.first, view, spacing, 0, j);
    cvol_view_ray_make(&second, view, spacing, 1, j);
    for (int a = 0; a < 3; a++)
        row.next[a] = second.start[a] - row.first.start[a];
    return row;
}

/* The label at a depth; 0: none is there. */
static int label_at_depth(const cvol_volume *labels, const cvol_view_ray *ray, float depth)
{
    double all;
    return isfinite(depth) && ray->rise > 0
               ? label_of_place(&all, labels, ray, ((double)depth - ray->depth) / ray->rise)
               : 0;
}

/* row: of a picture in parallel projection, else NULL. */
static int label_of_pixel(const cvol_volume *labels, const cvol_view *view, const row_rays *row,
                          float depth, int i, int j)
{
    const double *spacing = labels->grid.spacing;
    const double step = STEP * fmin(spacing[0], fmin(spacing[1], spacing[2]));
    cvol_view_ray ray;
    int label = 0;
    if (row) {
        ray = row->first;
        for (int a = 0; a < 3; a++)
            ray.start[a] += i * row->next[a];
        label = label_at_depth(labels, &ray, depth);
    }
    if (label || !cvol_view_ray_make(&ray, view, spacing, i, j))
        return label;
    if (!row)
        label = label_at_depth(labels, &ray, depth);
    return label ? label : label_of_ray(labels, &ray, step);
}

int cvol_image_colour_labels(cvol_context *context, cvol_image *image, const cvol_volume *labels,
                             const double *colours, size_t count,
                             const cvol_render_options *options)
{
    cvol_view view;
    if (!image->values || !image->depth || labels->grid.type != CVOL_UINT8)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "labels are coloured in pictures of floats with depths, from uint8");
    const int code = cvol_view_make(context, &view, &labels->grid, options);
    if (code)
        return code;
#pragma omp parallel for num_threads(cvol_context_threads(context)) schedule(dynamic, 4)
    for (int j = 0; j < image->height; j++) {
        const row_rays row = make_row(&view, labels->grid.spacing, j);
        for (int i = 0; i < image->width; i++) {
            const size_t at = (size_t)j * (size_t)image->width + (size_t)i;
            float *pixel = image->values + 4 * at;
            if (!(pixel[3] > 0))
                continue;
            const int label = label_of_pixel(labels, &view, view.perspective ? NULL : &row,
                                             image->depth[at], i, j);
            for (int c = 0; c < 3 && label > 0 && (size_t)label <= count; c++)
                pixel[c] *= (float)colours[3 * (label - 1) + c];
        }
    }
    return CVOL_OK;
}
