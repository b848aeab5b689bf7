/* Random small volumes, and pictures of them by all engines with random values of all options,
 * valid and invalid ones, one after the other by one renderer: a refusal has a sentence; a picture
 * has only finite values; and it is the picture of a new renderer with another number of threads,
 * so it does not depend on earlier ones. Each instruction set of the processor draws it within the
 * limits of doc/portability.md.
 *
 * usage: pictures [FIRST_SEED [COUNT [SECONDS]]]   one volume a seed
 *
 * A violation is printed with its seed and its options; the program then exits with 1. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/cpu.h"
#include "base/cpu_force.h"
#include "cvol/cvol.h"
#include "fuzz/seeds.h"
#include "random.h"
#include "support.h"
#include "support_samples.h"

enum { PICTURES_MAX = 4, SIZE_MAX_PIXELS = 40 };

typedef struct trial {
    cvol_context *context;
    random_state random;
    uint64_t seed;
    cvol_grid grid;
    cvol_volume *volume;
    cvol_array *array;
    cvol_engine engine;
    cvol_source source;
    cvol_render_options options;
    int is_float, has_depth, picture;
} trial;

static unsigned long long pictures, refusals, violations;

static size_t below(trial *t, size_t count)
{
    return random_below(&t->random, (uint32_t)count);
}

static int one_in(trial *t, size_t count)
{
    return below(t, count) == 0;
}

static double uniform(trial *t, double lo, double hi)
{
    return lo + (hi - lo) * ((double)(random_u64(&t->random) >> 11) * 0x1p-53);
}

static void violate(const trial *t, const char *what)
{
    const cvol_render_options *o = &t->options;
    violations++;
    printf(
        "seed %llu, picture %d: %s; %zux%zux%zu %s%s, engine %d, %dx%d%s%s, mode %d, level %d, "
        "step %g, oversample %g, keep %g, light %d, angles %g %g %g, zoom %g, fov %g, placed %d, "
        "clip %d %d, part %d, rows %d of %d\n",
        (unsigned long long)t->seed, t->picture, what, t->grid.dims[0], t->grid.dims[1],
        t->grid.dims[2], cvol_type_name(t->grid.type), t->source.array ? ", compressed" : "",
        (int)t->engine, o->width, o->height, t->is_float ? " floats" : "",
        t->has_depth ? " with depth" : "", (int)o->mode, o->level, o->step_voxels, o->oversample,
        o->keep_mb, o->shading.on, o->camera.azimuth_deg, o->camera.elevation_deg,
        o->camera.roll_deg, o->camera.zoom, o->camera.fov_deg, o->camera.placed, o->clip.axes,
        o->clip.planes, o->part.axes, o->rows.first, o->rows.of);
}

/* ---- volumes ------------------------------------------------------------------------------- */

static void make_volume(trial *t)
{
    static const size_t usual[] = {1, 2, 3, 15, 16, 17, 31, 32, 33};
    size_t dims[3];
    for (int a = 0; a < 3; a++)
        dims[a] = one_in(t, 3) ? usual[below(t, 9)] : 1 + below(t, 40);
    t->grid = cvol_grid_make(dims[0], dims[1], dims[2], (cvol_type)(CVOL_UINT8 + (int)below(t, 8)));
    for (int a = 0; a < 3 && one_in(t, 2); a++)
        t->grid.spacing[a] = pow(10, uniform(t, -1, 1));
    const size_t count = cvol_grid_samples(&t->grid), kind = below(t, 5);
    const int is_float = t->grid.type == CVOL_FLOAT32 || t->grid.type == CVOL_FLOAT64;
    const double size = is_float ? pow(10, uniform(t, -10, 10)) : 1;
    if (cvol_volume_create(t->context, &t->volume, &t->grid))
        abort();
    for (size_t i = 0; i < count; i++) {
        const double x = (double)(i % dims[0]), y = (double)(i / dims[0] % dims[1]),
                     z = (double)(i / dims[0] / dims[1]), noise = random_signed(&t->random);
        const double value = kind == 0   ? 0.3
                             : kind == 1 ? noise
                             : kind == 2 ? sin(0.5 * x) * cos(0.3 * (y + z))
                             : kind == 3 ? (hypot(hypot(x - 12, y - 9), z - 8) < 8)
                                         : (below(t, 60) == 0);
        support_store(t->volume->data, t->grid.type, i, value * size);
    }
}

static int make_source(trial *t)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    t->engine = (cvol_engine)(1 + (int)below(t, 5));
    const int takes_array = t->engine == CVOL_ENGINE_SHEET ||
                            (t->engine == CVOL_ENGINE_TRANSFORM && one_in(t, 2));
    t->source = (cvol_source){.size = sizeof t->source};
    if (!takes_array || one_in(t, 20)) {
        t->source.volume = t->volume;
        return 1;
    }
    options.block = one_in(t, 4) ? 8 : 16;
    options.lapped = (int)below(t, 2);
    options.lossless = one_in(t, 4);
    options.target_value = uniform(t, 2, 40);
    if (one_in(t, 6)) {
        options.has_fill = 1;
        options.fill = support_load(t->volume->data, t->grid.type, 0);
    }
    if (cvol_compress(t->context, &t->array, NULL, t->volume->data, &t->grid, &options)) {
        if (!*cvol_context_message(t->context))
            violate(t, "compression was refused without a sentence");
        return 0;
    }
    t->source.array = t->array;
    return 1;
}

static cvol_transfer *make_transfer(trial *t)
{
    cvol_transfer_point points[6];
    cvol_transfer *transfer;
    const size_t count = 1 + below(t, 6);
    double value = support_load(t->volume->data, t->grid.type, 0);
    const double last = support_load(t->volume->data, t->grid.type,
                                     below(t, cvol_grid_samples(&t->grid)));
    for (size_t i = 0; i < count; i++) {
        points[i] = (cvol_transfer_point){value, uniform(t, 0, 1), uniform(t, 0, 1),
                                          uniform(t, 0, 1), one_in(t, 3) ? 1 : uniform(t, 0, 1)};
        value += one_in(t, 4) ? 0 : fabs(last - value) * uniform(t, 0, 1);
    }
    if (cvol_transfer_create(t->context, &transfer, points, count))
        abort();
    return transfer;
}

/* ---- options ------------------------------------------------------------------------------- */

static void choose_camera(trial *t)
{
    cvol_camera *c = &t->options.camera;
    c->azimuth_deg = one_in(t, 2) ? 90.0 * (double)below(t, 5) : uniform(t, -400, 400);
    c->elevation_deg = one_in(t, 2) ? 90.0 * (double)below(t, 3) - 90 : uniform(t, -90, 90);
    c->roll_deg = one_in(t, 3) ? uniform(t, -180, 180) : 0;
    c->zoom = pow(10, uniform(t, -0.7, 0.9));
    if (one_in(t, 3))
        c->fov_deg = uniform(t, 1, 150);
    c->placed = c->fov_deg > 0 && one_in(t, 2);
    for (int a = 0; a < 3 && c->placed; a++) {
        c->eye[a] = uniform(t, -40, 40) * (one_in(t, 3) ? 0.1 : 1);
        c->look_at[a] = one_in(t, 2) ? 0 : uniform(t, -10, 10);
    }
}

static void choose_clip(trial *t)
{
    cvol_clip *clip = &t->options.clip;
    clip->axes = (int)below(t, 8);
    for (int a = 0; a < 3; a++) {
        const double last = (double)t->grid.dims[a] - 1;
        clip->from[a] = uniform(t, 0, last);
        clip->to[a] = uniform(t, clip->from[a], last);
    }
    clip->planes = one_in(t, 2) ? (int)below(t, CVOL_CLIP_PLANES + 1) : 0;
    for (int k = 0; k < clip->planes; k++)
        for (int i = 0; i < 4; i++)
            clip->plane[k][i] = uniform(t, -1, 1) * (i < 3 ? 1 : 15);
}

static void choose_light(trial *t)
{
    cvol_shading *s = &t->options.shading;
    cvol_illumination *i = &t->options.illumination;
    s->on = 1;
    for (int a = 0; a < 3 && one_in(t, 2); a++)
        s->light[a] = uniform(t, -1, 1);
    s->ambient = uniform(t, 0, 1);
    s->diffuse = uniform(t, 0, 1);
    s->specular = uniform(t, 0, 1);
    s->shininess = 1 + (int)below(t, 256);
    if (one_in(t, 4))
        s->gradient_opacity = uniform(t, 0, 1);
    if (one_in(t, 2))
        return;
    i->fill = uniform(t, 0, 1);
    i->occlusion = uniform(t, 0, 1);
    i->shadows = uniform(t, 0, 1);
    i->in_view = (int)below(t, 3) - 1;
    i->keeps_brightness = (int)below(t, 2);
    i->samples = one_in(t, 4) ? 2 + (int)below(t, 20) : 0;
}

static void choose_engine_options(trial *t)
{
    cvol_render_options *o = &t->options;
    o->sheet.footprint = (cvol_sheet_footprint)(int)below(t, 4);
    o->sheet.ray_order = (cvol_ray_order)(int)below(t, 3);
    if (one_in(t, 4))
        o->sheet.sigma = uniform(t, 0.5, 1);
    if (one_in(t, 2)) {
        o->splat.footprint = (cvol_footprint)(1 + (int)below(t, 4));
        o->splat.size = 3 + (int)below(t, 9);
        o->splat.plane = (cvol_footprint_plane)(int)below(t, 3);
        o->splat.order = (cvol_order)(int)below(t, 4);
    }
    if (one_in(t, 2)) {
        static const int tiles[] = {0, 8, 16, 32};
        o->transform.transform = (cvol_transform)(CVOL_DCT + (int)below(t, 3));
        o->transform.tile = tiles[below(t, 4)];
        o->transform.rho = uniform(t, 0.01, 1.2);
        o->transform.schedule = (cvol_schedule)(1 + (int)below(t, 2));
    }
    o->fourier.depth_cue = one_in(t, 2) ? uniform(t, 0, 1) : 0;
}

/* Now and then a value that no option has. */
static void spoil(trial *t)
{
    static const double numbers[] = {NAN, INFINITY, -INFINITY, -1, 1e300, 1e-300, 0};
    static const int integers[] = {-1, 0, 4, 7, 99, 1 << 20, INT32_MAX, INT32_MIN};
    cvol_render_options *o = &t->options;
    double *const reals[] = {&o->camera.azimuth_deg, &o->camera.zoom,     &o->camera.fov_deg,
                             &o->camera.eye[0],      &o->camera.up[1],    &o->step_voxels,
                             &o->oversample,         &o->keep_mb,         &o->background[1],
                             &o->window[0],          &o->shading.diffuse, &o->surface.value,
                             &o->sheet.sigma,        &o->splat.sigma,     &o->transform.rho,
                             &o->fourier.depth_cue,  &o->clip.from[0],    &o->clip.plane[0][3],
                             &o->illumination.fill,  &o->part.from[1],    &o->shading.light[2]};
    int *const whole[] = {&o->level,       &o->shading.shininess,    &o->splat.size,
                          &o->clip.planes, &o->transform.tile,       &o->rows.first,
                          &o->rows.of,     &o->illumination.samples, &o->clip.axes,
                          &o->part.axes,   &o->illumination.in_view, &o->camera.placed};
    switch (below(t, 3)) {
    case 0:
        *reals[below(t, sizeof reals / sizeof *reals)] = numbers[below(t, 7)];
        break;
    case 1:
        *whole[below(t, sizeof whole / sizeof *whole)] = integers[below(t, 8)];
        break;
    default:
        o->mode = (cvol_mode)(int)below(t, 8);
    }
}

static void choose_options(trial *t)
{
    cvol_render_options *o = &t->options;
    *o = cvol_render_options_defaults();
    o->width = 1 + (int)below(t, SIZE_MAX_PIXELS);
    o->height = 1 + (int)below(t, SIZE_MAX_PIXELS);
    o->mode = t->engine == CVOL_ENGINE_FOURIER && !one_in(t, 8)
                  ? CVOL_MODE_XRAY
                  : (cvol_mode)(1 + (int)below(t, one_in(t, 2) ? 1 : 5));
    choose_camera(t);
    if (one_in(t, 3))
        choose_clip(t);
    if (one_in(t, 2))
        choose_light(t);
    if (one_in(t, 3))
        choose_engine_options(t);
    if (t->engine == CVOL_ENGINE_SHEET && one_in(t, 3))
        o->level = (int)below(t, 4);
    if (one_in(t, 4))
        o->step_voxels = uniform(t, 0.2, 3);
    if (one_in(t, 4))
        o->oversample = uniform(t, 0.25, 4);
    o->keep_mb = one_in(t, 2) ? uniform(t, 0, 4) : 0;
    o->surface.value = support_load(t->volume->data, t->grid.type,
                                    below(t, cvol_grid_samples(&t->grid)));
    for (int c = 0; c < 3; c++) {
        o->surface.colour[c] = uniform(t, 0, 1);
        o->background[c] = one_in(t, 2) ? 0 : uniform(t, 0, 1);
    }
    if (one_in(t, 8)) {
        o->rows.of = o->height + (int)below(t, 30);
        o->rows.first = (int)below(t, (size_t)(o->rows.of - o->height) + 1);
    }
    if (one_in(t, 5))
        spoil(t);
    t->is_float = (int)below(t, 2);
    t->has_depth = one_in(t, 6);
}

/* ---- pictures ------------------------------------------------------------------------------ */

static cvol_image *make_image(const trial *t)
{
    cvol_image *image;
    const int code = (t->is_float ? cvol_image_create_float : cvol_image_create)(
        t->context, &image, t->options.width, t->options.height);
    if (code || (t->has_depth && cvol_image_add_depth(t->context, image)))
        abort();
    return image;
}

static size_t pixels_of(const cvol_image *image)
{
    return (size_t)image->width * (size_t)image->height;
}

static void check_values(const trial *t, const cvol_image *image)
{
    for (size_t i = 0; t->is_float && i < 4 * pixels_of(image); i++)
        if (!isfinite(image->values[i])) {
            violate(t, "a value is not finite");
            return;
        }
    for (size_t i = 0; t->has_depth && i < pixels_of(image); i++)
        if (isnan(image->depth[i])) {
            violate(t, "a depth is no number");
            return;
        }
}

/* The largest difference of colours and opacity of two pictures, in units of 1/255. */
static double largest_of(const trial *t, const cvol_image *a, const cvol_image *b)
{
    double most = 0;
    for (size_t i = 0; i < 4 * pixels_of(a); i++)
        most = fmax(most, t->is_float ? 255 * fabs((double)a->values[i] - (double)b->values[i])
                                      : fabs((double)a->rgba[i] - (double)b->rgba[i]));
    return most;
}

/* The same; of depths: 1000. */
static double distance_of(const trial *t, const cvol_image *a, const cvol_image *b)
{
    if (t->has_depth && memcmp(a->depth, b->depth, pixels_of(a) * sizeof *a->depth) != 0)
        return 1000;
    return largest_of(t, a, b);
}

/* The picture of a new renderer. */
static void check_again(trial *t, const cvol_image *image, const cvol_transfer *transfer)
{
    cvol_renderer *renderer = NULL;
    cvol_image *second = make_image(t);
    cvol_context_set_threads(t->context, 1 + (int)below(t, 3));
    if (cvol_renderer_create(t->context, &renderer, t->engine, &t->source) ||
        cvol_renderer_set_transfer(t->context, renderer, transfer) ||
        cvol_renderer_render(t->context, renderer, second, &t->options))
        violate(t, cvol_context_message(t->context));
    else if (distance_of(t, image, second) > 0) {
        char what[80];
        snprintf(what, sizeof what, "a new renderer's picture differs by %g of 255",
                 distance_of(t, image, second));
        violate(t, what);
    }
    cvol_renderer_free(renderer);
    cvol_image_free(second);
}

/* ---- instruction sets ---------------------------------------------------------------------- */

/* The limits of doc/portability.md for random volumes; with AVX-512 of unlit pictures: the light of
 * noise, with a high shininess, shows the rounding of int16 samples. */
enum { AVX2_LARGEST = 2, AVX512_LARGEST = 16 };

/* A function without jumps over all values. Where a random one jumps, at the value of some sample,
 * rounding decides. */
static cvol_transfer *make_smooth_transfer(const trial *t)
{
    double lo = support_load(t->volume->data, t->grid.type, 0), hi = lo;
    for (size_t i = 0; i < cvol_grid_samples(&t->grid); i++) {
        const double value = support_load(t->volume->data, t->grid.type, i);
        lo = fmin(lo, value);
        hi = fmax(hi, value);
    }
    const double span = hi > lo ? hi - lo : 1;
    const cvol_transfer_point points[] = {{lo - 0.2 * span, 0.9, 0.2, 0.1, 0},
                                          {lo + 0.5 * span, 0.3, 0.8, 0.4, 0.5},
                                          {hi + 0.2 * span, 0.2, 0.4, 1, 0}};
    cvol_transfer *transfer;
    if (cvol_transfer_create(t->context, &transfer, points, 3))
        abort();
    return transfer;
}

/* The picture by a new renderer and a set; NULL: refused. */
static cvol_image *draw_by_set(const trial *t, cvol_cpu set, const cvol_transfer *transfer)
{
    cvol_renderer *renderer = NULL;
    cvol_image *image = make_image(t);
    cvol_cpu_force((int)set);
    if (cvol_renderer_create(t->context, &renderer, t->engine, &t->source) ||
        cvol_renderer_set_transfer(t->context, renderer, transfer) ||
        cvol_renderer_render(t->context, renderer, image, &t->options)) {
        violate(t, cvol_context_message(t->context));
        cvol_image_free(image);
        image = NULL;
    }
    cvol_renderer_free(renderer);
    return image;
}

static void compare_sets(const trial *t, cvol_cpu set, const cvol_transfer *transfer, double limit)
{
    const cvol_cpu widest = cvol_cpu_best();
    if (set > widest)
        return;
    cvol_image *base = draw_by_set(t, CVOL_CPU_BASE, transfer),
               *other = draw_by_set(t, set, transfer);
    cvol_cpu_force((int)widest);
    if (base && other && largest_of(t, base, other) > limit) {
        char what[80];
        snprintf(what, sizeof what, "%s differs from the base set by %g of 255", cvol_cpu_name(set),
                 largest_of(t, base, other));
        violate(t, what);
    }
    cvol_image_free(base);
    cvol_image_free(other);
}

static void check_sets(const trial *t, const cvol_transfer *transfer)
{
    cvol_transfer *smooth = make_smooth_transfer(t);
    compare_sets(t, CVOL_CPU_AVX2, transfer, AVX2_LARGEST);
    if (!t->options.shading.on)
        compare_sets(t, CVOL_CPU_AVX512, smooth, AVX512_LARGEST);
    cvol_transfer_free(smooth);
}

static void draw(trial *t, cvol_renderer *renderer, const cvol_transfer *transfer)
{
    choose_options(t);
    cvol_image *image = make_image(t);
    cvol_context_set_threads(t->context, 1 + (int)below(t, 3));
    if (cvol_renderer_render(t->context, renderer, image, &t->options)) {
        refusals++;
        if (!*cvol_context_message(t->context))
            violate(t, "refused without a sentence");
        else if (test_verbose())
            printf("seed %llu, picture %d: refused: %s\n", (unsigned long long)t->seed, t->picture,
                   cvol_context_message(t->context));
    } else {
        pictures++;
        check_values(t, image);
        check_again(t, image, transfer);
        check_sets(t, transfer);
    }
    cvol_image_free(image);
}

static void run_trial(uint64_t seed, cvol_context *context)
{
    trial t = {.context = context, .random = {seed}, .seed = seed};
    cvol_renderer *renderer = NULL;
    make_volume(&t);
    if (make_source(&t)) {
        cvol_transfer *transfer = make_transfer(&t);
        const int count = 1 + (int)below(&t, PICTURES_MAX);
        int code = cvol_renderer_create(context, &renderer, t.engine, &t.source);
        if (!code)
            code = cvol_renderer_set_transfer(context, renderer, transfer);
        if (code && !*cvol_context_message(context))
            violate(&t, "a renderer was refused without a sentence");
        for (; t.picture < count && !code; t.picture++) {
            if (t.picture && one_in(&t, 3)) {
                cvol_transfer_free(transfer);
                transfer = make_transfer(&t);
                code = cvol_renderer_set_transfer(context, renderer, transfer);
            }
            draw(&t, renderer, transfer);
        }
        cvol_renderer_free(renderer);
        cvol_transfer_free(transfer);
    }
    cvol_array_free(t.array);
    cvol_volume_free(t.volume);
}

int main(int argc, char **argv)
{
    const uint64_t last = try_seeds(argc, argv, 500, run_trial);
    printf("pictures: up to seed %llu: %llu pictures, %llu refused, %llu violations\n",
           (unsigned long long)last, pictures, refusals, violations);
    return violations != 0;
}
