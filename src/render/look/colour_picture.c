/* Colours of samples in a picture of their shape (cvol/look.h).
 *
 * Two walks along the rays of the pixels: the first finds the bricks that the second reads; these
 * are evaluated in between. Both walks skip cells that the transfer function does not show, and end
 * behind the depth of the pixel, where little is seen. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "render/look/colours.h"
#include "render/transfer/transfer.h"
#include "render/view/camera.h"
#include "render/view/options.h"
#include "render/view/view_ray.h"

/* Of samples along a ray, in mean spacings. */
#define STEP 0.5
/* A ray ends behind the depth of its pixel: so many mean spacings, or so much more than lies
 * between its first visible cell and the depth. In even matter, at BEHIND_PART 4.6 of the light
 * 1/50 is left. */
#define BEHIND 12
#define BEHIND_PART 5
/* The part of the light at which a ray ends. */
#define LEAST 0.02F
/* Opacities by sums of components: steps from black to the largest. */
#define OPACITIES 1024
/* Light makes colours brighter by this part at most. */
#define GLARE 0.2F
/* Sums of this many times the solid one are thought to be free of background. */
#define PURE 1.5

typedef struct picture {
    const cvol_colours *colours;
    cvol_view view;
    float opacities[OPACITIES + 1], weights[OPACITIES + 1];
} picture;

/* What a ray has seen. */
typedef struct seen {
    float rgb[3], weight, left; /* by opacity; left: of the light */
    float densest[3], most; /* of a ray through nothing opaque: the colour of its densest sample */
} seen;

static void fill_opacities(picture *p, const cvol_transfer *transfer)
{
    const cvol_colours *c = p->colours;
    for (int i = 0; i <= OPACITIES; i++) {
        const double plain = (double)i / OPACITIES,
                     sum = c->bright > 0 ? fmax(c->bright - plain, 0) : plain,
                     share = fmax((sum - c->ends[0]) / (c->ends[1] - c->ends[0]), 0),
                     pure = c->has_alpha ? 1 : fmin(share / PURE, 1);
        const cvol_transfer_point at = cvol_transfer_at(transfer, 255 * fmin(share, 1));
        p->opacities[i] = (float)cvol_opacity_over(at.opacity, STEP);
        p->weights[i] = p->opacities[i] * (float)(pure * pure);
    }
}

/* A cell on a ray, and its brick. */
typedef struct cell {
    size_t index, brick;
    double first[3], size[3]; /* of the brick: its first sample, and the distance of its last one */
    double leaves;            /* where the ray leaves the cell */
} cell;

/* The ray leaves the cell at least a small part of a step behind `at`. */
static cell find_cell(const cvol_colours *c, const cvol_view_ray *ray, double at, double step)
{
    cell out = {.leaves = INFINITY};
    const size_t side = c->cell_side;
    for (int a = 2; a >= 0; a--) {
        const double place = ray->start[a] + at * ray->direction[a], speed = ray->direction[a];
        size_t number = place > 0 ? (size_t)place / side : 0;
        if (number >= c->cells[a])
            number = c->cells[a] - 1;
        const size_t brick = number * side / CVOL_COLOUR_SIDE;
        out.index = out.index * c->cells[a] + number;
        out.brick = out.brick * c->bricks[a] + brick;
        out.first[a] = (double)(brick * CVOL_COLOUR_SIDE);
        out.size[a] = fmin(CVOL_COLOUR_SIDE, (double)(c->grid.dims[a] - 1) - out.first[a]);
        if (speed > 0 && number + 1 < c->cells[a])
            out.leaves = fmin(out.leaves, ((double)((number + 1) * side) - ray->start[a]) / speed);
        else if (speed < 0 && number)
            out.leaves = fmin(out.leaves, ((double)(number * side) - ray->start[a]) / speed);
    }
    out.leaves = fmax(out.leaves, fmax(at + 1e-6 * step, nextafter(at, INFINITY)));
    return out;
}

/* The components at a place on the ray, 0 to 255. */
static void interpolate(float out[CVOL_COLOURS_MAX], const uint8_t *samples, const cell *in,
                        const cvol_view_ray *ray, double at)
{
    static const size_t strides[3] = {1, CVOL_COLOUR_STRIDE,
                                      (size_t)CVOL_COLOUR_STRIDE * CVOL_COLOUR_STRIDE};
    float part[3];
    size_t first = 0, next[3];
    for (int a = 0; a < 3; a++) {
        const double inside = ray->start[a] + at * ray->direction[a] - in->first[a],
                     place = fmin(fmax(inside, 0), in->size[a]);
        const size_t low = (size_t)place;
        part[a] = (float)(place - (double)low);
        first += strides[a] * low;
        next[a] = (double)low < in->size[a] ? strides[a] : 0;
    }
    for (int c = 0; c < CVOL_COLOURS_MAX; c++)
        out[c] = 0;
    for (int k = 0; k < 8; k++) {
        const float weight = (k & 1 ? part[0] : 1 - part[0]) * (k & 2 ? part[1] : 1 - part[1]) *
                             (k & 4 ? part[2] : 1 - part[2]);
        const uint8_t *sample = samples +
                                CVOL_COLOURS_MAX * (first + (k & 1 ? next[0] : 0) +
                                                    (k & 2 ? next[1] : 0) + (k & 4 ? next[2] : 0));
        for (int c = 0; c < CVOL_COLOURS_MAX; c++)
            out[c] += weight * (float)sample[c];
    }
}

/* Adds a sample of the ray. */
static void add_sample(seen *s, const picture *p, const float components[CVOL_COLOURS_MAX])
{
    const cvol_colours *c = p->colours;
    const size_t coloured = c->count - (size_t)c->has_alpha;
    float rgb[3] = {0}, sum = 0;
    for (size_t i = 0; i < coloured; i++) {
        sum += components[i];
        for (int k = 0; k < 3; k++)
            rgb[k] += components[i] * (1.0F / 255) * c->rgb[3 * i + (size_t)k];
    }
    const float share = c->has_alpha ? components[coloured] * (1.0F / 255)
                                     : sum * (1.0F / 255) / (float)coloured,
                dense = c->bright > 0 ? -share : share,
                weight = s->left * p->weights[(int)(share * OPACITIES + 0.5F)];
    for (int k = 0; k < 3; k++) {
        s->rgb[k] += weight * rgb[k];
        if (dense > s->most)
            s->densest[k] = rgb[k];
    }
    s->most = fmaxf(s->most, dense);
    s->weight += weight;
    s->left *= 1 - p->opacities[(int)(share * OPACITIES + 0.5F)];
}

/* A ray as far as it is walked. */
typedef struct walked_ray {
    cvol_view_ray ray;
    double to, depth; /* depth: of the pixel; INFINITY: none */
} walked_ray;

/* Where a ray ends, which meets the first visible cell at `first`: behind its depth so far as what
 * is before it suggests. */
static double find_end(const walked_ray *w, const picture *p, double first)
{
    return fmin(w->to,
                w->depth + fmax(BEHIND * p->view.mean_spacing, BEHIND_PART * (w->depth - first)));
}

/* A ray that meets nothing visible, at the edge of the shape or of the volume: the sample nearest
 * to its depth, or to its middle. */
static void take_nearest(seen *s, const picture *p, const walked_ray *w)
{
    const cvol_colours *c = p->colours;
    const double middle = (w->ray.near + w->ray.far) / 2,
                 at = isfinite(w->depth) ? w->depth : middle;
    if (!isfinite(at))
        return;
    const cell in = find_cell(c, &w->ray, at, p->view.mean_spacing);
    const uint8_t *samples = c->samples[in.brick];
    if (!s) {
#pragma omp atomic write
        c->needed[in.brick] = 1;
    } else if (samples) {
        float components[CVOL_COLOURS_MAX];
        interpolate(components, samples, &in, &w->ray, at);
        add_sample(s, p, components);
    }
}

/* Walks along a ray; without `s` it marks the bricks on the way. */
static void walk(seen *s, const picture *p, const walked_ray *w)
{
    const cvol_colours *c = p->colours;
    const double step = STEP * p->view.mean_spacing;
    double to = w->to;
    int has_end = 0;
    /* From very far away, a step is too small to be added. */
    for (double at = w->ray.near; at <= to && at + step > at;) {
        const cell in = find_cell(c, &w->ray, at, step);
        const uint8_t *samples = c->samples[in.brick]; /* NULL: the first walk missed a corner */
        if (!c->visible[in.index]) {
            at = in.leaves;
            continue;
        }
        if (!has_end)
            to = find_end(w, p, at);
        has_end = 1;
        if (!s) {
#pragma omp atomic write
            c->needed[in.brick] = 1;
        }
        for (; s && samples && at < in.leaves && at <= to; at += step) {
            float components[CVOL_COLOURS_MAX];
            interpolate(components, samples, &in, &w->ray, at);
            add_sample(s, p, components);
            if (s->left < LEAST)
                return;
        }
        at = fmax(at, in.leaves);
    }
    if (!has_end)
        take_nearest(s, p, w);
}

static void find_ray(walked_ray *out, const picture *p, float depth, int i, int j)
{
    cvol_view_ray_make(&out->ray, &p->view, p->colours->grid.spacing, i, j);
    out->to = out->ray.far;
    out->depth = isfinite(depth) && out->ray.rise > 0
                     ? ((double)depth - out->ray.depth) / out->ray.rise
                     : INFINITY;
}

/* Light of more than 1 is brighter, but for the most part keeps the colour: up to 1 + GLARE. */
static float shade(float light)
{
    return light > 1 ? 1 + GLARE * (1 - expf((1 - light) / GLARE)) : light;
}

static void colour_pixel(float *pixel, const picture *p, float depth, int i, int j)
{
    walked_ray ray;
    seen s = {.left = 1, .most = -INFINITY};
    find_ray(&ray, p, depth, i, j);
    walk(&s, p, &ray);
    if (!(s.most > -INFINITY))
        return;
    for (int k = 0; k < 3; k++) {
        const float colour = s.weight > 0 ? s.rgb[k] / s.weight : s.densest[k];
        const float light = pixel[k] / ((float)CVOL_COLOUR_GREY * pixel[3]);
        pixel[k] = fminf(colour * shade(light), 1) * pixel[3];
    }
}

static void mark_pixel(const picture *p, float depth, int i, int j)
{
    walked_ray ray;
    find_ray(&ray, p, depth, i, j);
    walk(NULL, p, &ray);
}

static void each_pixel(cvol_context *context, cvol_image *image, const picture *p, int is_marking)
{
#pragma omp parallel for num_threads(cvol_context_threads(context)) schedule(dynamic, 4)
    for (int j = 0; j < image->height; j++)
        for (int i = 0; i < image->width; i++) {
            const size_t at = (size_t)j * (size_t)image->width + (size_t)i;
            if (!(image->values[4 * at + 3] > 0))
                continue;
            if (is_marking)
                mark_pixel(p, image->depth[at], i, j);
            else
                colour_pixel(image->values + 4 * at, p, image->depth[at], i, j);
        }
}

int cvol_image_colour_components(cvol_context *context, cvol_image *image, cvol_colours *colours,
                                 const cvol_transfer *transfer, const cvol_render_options *options)
{
    picture p = {.colours = colours};
    if (!image->values || !image->depth)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "colours are put into pictures of floats with depths");
    int code = cvol_view_make(context, &p.view, &colours->grid, options);
    if (code)
        return code;
    fill_opacities(&p, transfer);
    cvol_colours_find_visible(colours, transfer);
    memset(colours->needed, 0, colours->brick_count);
    each_pixel(context, image, &p, 1);
    code = cvol_report_progress(context, "colours", 0);
    if (!code)
        code = cvol_colours_evaluate(context, colours);
    if (!code)
        code = cvol_report_progress(context, "colours", 0.5);
    if (!code)
        each_pixel(context, image, &p, 0);
    return code;
}
