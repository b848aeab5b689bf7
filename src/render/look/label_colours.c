/* Colours of labels in a picture of their shape (cvol/look.h).
 *
 * The ray of a pixel reaches half of its opacity at its depth. The pixel gets the colour of the
 * label that has the largest part of the interpolated samples there: between the eight samples
 * around a place, each label has the sum of the weights of its samples. At the edge of the shape
 * and where it is thin, rays do not reach half: they get the colour of the place along the ray
 * where labels have the largest part. Pixels of a translucent shape get the mean colour along their
 * rays. A pixel whose ray meets no label shows the blur of the shape, most at coarse levels, and is
 * cleared. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "cvol/look.h"
#include "render/transfer/transfer.h"
#include "render/view/camera.h"
#include "render/view/view_ray.h"

/* Steps along a ray, in samples. */
#define STEP 0.5
/* Samples along each axis of a block that is skipped if it has no label. */
#define BLOCK 8
/* Translucent shapes: steps in mean spacings, the least opacity that hides, and the part of the
 * light at which a ray ends. */
#define MEAN_STEP 0.5
#define HIDING 0.9
#define LEAST 0.02
/* The value of the shape inside labels. */
#define INSIDE 255
/* Pixels without a depth for which blocks are worth their time. */
#define PIXELS_LEAST 2000

/* Blocks of samples, 1 where a place in the block is near a label. */
typedef struct occupancy {
    uint8_t *blocks; /* NULL: unknown, every block counts */
    size_t dims[3];
} occupancy;

/* 1 if one of `count` samples is a label. */
static int has_label(const uint8_t *samples, size_t count)
{
    static const uint8_t none[BLOCK + 1] = {0};
    return memcmp(samples, none, count) != 0;
}

/* The samples of a block are those between which its places lie. */
static int is_occupied(const cvol_volume *labels, const size_t block[3])
{
    const size_t *n = labels->grid.dims;
    size_t from[3], count[3];
    for (int a = 0; a < 3; a++) {
        from[a] = block[a] * BLOCK;
        count[a] = n[a] - from[a] < BLOCK + 1 ? n[a] - from[a] : BLOCK + 1;
    }
    for (size_t z = from[2]; z < from[2] + count[2]; z++)
        for (size_t y = from[1]; y < from[1] + count[1]; y++)
            if (has_label((const uint8_t *)labels->data + from[0] + n[0] * (y + n[1] * z),
                          count[0]))
                return 1;
    return 0;
}

/* Without memory `blocks` is NULL. */
static occupancy find_occupancy(cvol_context *context, const cvol_volume *labels)
{
    occupancy out = {.blocks = NULL};
    for (int a = 0; a < 3; a++)
        out.dims[a] = (labels->grid.dims[a] + BLOCK - 1) / BLOCK;
    out.blocks = malloc(out.dims[0] * out.dims[1] * out.dims[2]);
    if (!out.blocks)
        return out;
#pragma omp parallel for num_threads(cvol_context_threads(context)) schedule(dynamic, 1)
    for (size_t z = 0; z < out.dims[2]; z++)
        for (size_t y = 0; y < out.dims[1]; y++)
            for (size_t x = 0; x < out.dims[0]; x++)
                out.blocks[x + out.dims[0] * (y + out.dims[1] * z)] = (uint8_t)is_occupied(
                    labels, (const size_t[3]){x, y, z});
    return out;
}

/* 1 if no label is near a place in samples. */
static int is_empty(const occupancy *o, const double place[3])
{
    size_t at[3];
    for (int a = 0; a < 3; a++) {
        const size_t block = place[a] > 0 ? (size_t)place[a] / BLOCK : 0;
        at[a] = block < o->dims[a] ? block : o->dims[a] - 1;
    }
    return o->blocks && !o->blocks[at[0] + o->dims[0] * (at[1] + o->dims[1] * at[2])];
}

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
static int label_of_ray(const cvol_volume *labels, const occupancy *o, const cvol_view_ray *ray,
                        double step)
{
    double most = 0;
    int label = 0;
    for (double along = ray->near; along <= ray->far && most < 0.5 && along + step > along;
         along += step) {
        double all, place[3];
        for (int a = 0; a < 3; a++)
            place[a] = ray->start[a] + along * ray->direction[a];
        if (is_empty(o, place))
            continue;
        const int here = label_at(&all, labels, place);
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
static int label_of_pixel(const cvol_volume *labels, const occupancy *o, const cvol_view *view,
                          const row_rays *row, float depth, int i, int j)
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
    return label ? label : label_of_ray(labels, o, &ray, step);
}

/* What the pixels of a picture get their colours from. */
typedef struct picture {
    const cvol_volume *labels;
    const double *colours; /* [3 count] */
    size_t count;
    occupancy blocks;
    cvol_view view;
    double opacity; /* of a step along a ray; 0: the shape is opaque */
} picture;

static double colour_of(const picture *p, int label, int component)
{
    return label > 0 && (size_t)label <= p->count ? p->colours[3 * (label - 1) + component] : 1;
}

/* The mean colour of labels along the ray of a pixel; 0: it meets none. */
static int find_mean(double rgb[3], const picture *p, int i, int j)
{
    const double step = MEAN_STEP * p->view.mean_spacing;
    double sum[3] = {0}, weights = 0, left = 1;
    cvol_view_ray ray;
    if (!cvol_view_ray_make(&ray, &p->view, p->labels->grid.spacing, i, j))
        return 0;
    for (double along = ray.near; along <= ray.far && left > LEAST && along + step > along;
         along += step) {
        double part, place[3];
        for (int a = 0; a < 3; a++)
            place[a] = ray.start[a] + along * ray.direction[a];
        if (is_empty(&p->blocks, place))
            continue;
        const int label = label_at(&part, p->labels, place);
        const double opacity = p->opacity * fmin(part, 1);
        for (int c = 0; c < 3; c++)
            sum[c] += left * opacity * colour_of(p, label, c);
        weights += left * opacity;
        left *= 1 - opacity;
    }
    for (int c = 0; c < 3 && weights > 0; c++)
        rgb[c] = sum[c] / weights;
    return weights > 0;
}

static void colour_row(cvol_image *image, const picture *p, int j)
{
    const row_rays row = make_row(&p->view, p->labels->grid.spacing, j);
    for (int i = 0; i < image->width; i++) {
        const size_t at = (size_t)j * (size_t)image->width + (size_t)i;
        float *pixel = image->values + 4 * at;
        double rgb[3] = {0};
        int met;
        if (!(pixel[3] > 0))
            continue;
        if (p->opacity > 0) {
            met = find_mean(rgb, p, i, j);
        } else {
            const int label = label_of_pixel(p->labels, &p->blocks, &p->view,
                                             p->view.perspective ? NULL : &row, image->depth[at], i,
                                             j);
            for (int c = 0; c < 3; c++)
                rgb[c] = colour_of(p, label, c);
            met = label > 0;
        }
        if (!met) {
            memset(pixel, 0, 4 * sizeof *pixel);
            image->depth[at] = INFINITY;
            continue;
        }
        for (int c = 0; c < 3; c++)
            pixel[c] *= (float)rgb[c];
    }
}

/* 1 if many rays have to be searched for a label. */
static int has_many_rays(const cvol_image *image)
{
    size_t count = 0;
    for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++)
        count += image->values[4 * i + 3] > 0 && !isfinite(image->depth[i]);
    return count >= PIXELS_LEAST;
}

int cvol_image_colour_labels(cvol_context *context, cvol_image *image, const cvol_volume *labels,
                             const double *colours, size_t count, const cvol_transfer *transfer,
                             const cvol_render_options *options)
{
    const double opacity = transfer ? cvol_transfer_at(transfer, INSIDE).opacity : 1;
    picture p = {.labels = labels,
                 .colours = colours,
                 .count = count,
                 .opacity = opacity < HIDING ? cvol_opacity_over(opacity, MEAN_STEP) : 0};
    if (!image->values || !image->depth || labels->grid.type != CVOL_UINT8)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "labels are coloured in pictures of floats with depths, from uint8");
    const int code = cvol_view_make(context, &p.view, &labels->grid, options);
    if (code)
        return code;
    if (p.opacity > 0 || has_many_rays(image))
        p.blocks = find_occupancy(context, labels);
#pragma omp parallel for num_threads(cvol_context_threads(context)) schedule(dynamic, 4)
    for (int j = 0; j < image->height; j++)
        colour_row(image, &p, j);
    free(p.blocks.blocks);
    return CVOL_OK;
}
