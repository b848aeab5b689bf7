/* --turntable and --over-time: pictures from all around the volume, or of all times, as numbered
 * files or as an animation. */
#include <stdlib.h>
#include <string.h>

#include "tools/render/movie.h"
#include "tools/render/render_parts.h"
#include "tools/render/render_picture.h"

#define FRAMES_MAX 100000
#define PALETTE_FRAMES 8 /* sample pictures from which GIF chooses its colours */

int check_turntable(const scene *s, const render_arguments *a)
{
    const char *given = a->fps_given ? "--fps" : a->quality_given ? "--quality" : NULL;
    const int is_photo = a->output && (picture_kind_of(a->output) == PICTURE_JPEG ||
                                       picture_kind_of(a->output) == PICTURE_WEBP);
    if (!a->turntable_given && a->output && is_movie(a->output) && !is_photo)
        return report_error(EXIT_MISUSED,
                            "%s: is the name of an animation: give --turntable N or --over-time",
                            a->output);
    if (!a->turntable_given)
        return a->fps_given || (given && !is_photo)
                   ? report_error(EXIT_MISUSED, "%s works only with --turntable and --over-time%s",
                                  given, a->fps_given ? "" : ", and with JPEG and WebP")
               : a->quality < 0 || a->quality > 100
                   ? report_error(EXIT_MISUSED, "--quality is %d, must be 0 to 100", a->quality)
                   : EXIT_DONE;
    if (a->turntable < 1 || a->turntable > FRAMES_MAX)
        return report_error(EXIT_MISUSED, "--turntable is %d, must be 1 to %d", a->turntable,
                            FRAMES_MAX);
    if (a->progressive || a->poses)
        return report_error(EXIT_MISUSED, "--turntable cannot be combined with --%s",
                            a->progressive ? "progressive" : "poses");
    if (!a->output)
        return report_error(EXIT_MISUSED, "no output: give -o turn.gif or -o 'turn-{n}.png'");
    if (a->quality < 0 || a->quality > 100)
        return report_error(EXIT_MISUSED, "--quality is %d, must be 0 to 100", a->quality);
    if (!(a->fps > 0 && a->fps <= 1000))
        return report_error(EXIT_MISUSED, "--fps is %g, must be above 0 and at most 1000", a->fps);
    if (!is_movie(a->output)) {
        if (a->fps_given || (given && !is_photo))
            return report_error(EXIT_MISUSED, "%s works only with animations, and %s is a picture",
                                given, a->output);
        if (picture_kind_of(a->output) == PICTURE_CVI)
            return report_error(EXIT_MISUSED,
                                "%s: --turntable does not write compressed pictures: write .png",
                                a->output);
        if (picture_kind_of(a->output) != PICTURE_NONE && !strstr(a->output, "{n}"))
            return report_error(
                EXIT_MISUSED,
                "%s: this is one name for several pictures: put {n} into it, as in -o "
                "'turn-{n}.png', or write an animation, turn.gif",
                a->output);
        return check_kind(s, a);
    }
    if (a->bits == 16)
        return report_error(EXIT_MISUSED, "%s: --bits 16 works only with PNG files", a->output);
    if (a->transparent && !has_ending(a->output, ".webp"))
        return report_error(EXIT_MISUSED,
                            "%s: --background transparent works only with PNG and WebP", a->output);
    return EXIT_DONE;
}

static double angle_of(const render_arguments *a, int frame)
{
    return 360.0 * frame / a->turntable;
}

/* The settings of an animation. */
typedef struct film_of {
    scene *s;
    render_arguments *a;
    const char *path;
} film_of;

/* Prepares the scene of a frame. Exit status. */
static int set_frame(cvol_context *context, const film_of *f, int frame)
{
    return f->a->over_time ? open_time(context, f->s, f->a, f->path, frame)
                           : aim_camera(context, f->s, f->a, angle_of(f->a, frame));
}

/* Renders a frame, as bytes. Exit status. */
static int take_frame(cvol_context *context, const film_of *f, int frame, cvol_image **image,
                      double *render_ms)
{
    *image = NULL;
    const int status = set_frame(context, f, frame);
    return status ? status : take_picture(context, f->s, f->a, 0, image, render_ms);
}

/* Shows some frames, spread over the turn, to the animation, which chooses its colours. m: NULL in
 * processes that do not write (render_parts.h), here and below. */
static int sample_palette(cvol_context *context, const film_of *f, movie *m)
{
    const render_arguments *a = f->a;
    const int count = a->turntable < PALETTE_FRAMES ? a->turntable : PALETTE_FRAMES;
    int status = EXIT_DONE;
    for (int k = 0; k < count && !status; k++) {
        cvol_image *image;
        double ms;
        override_progress("choosing colours", (double)k / count);
        status = take_frame(context, f, (int)((double)k * a->turntable / count), &image, &ms);
        if (!status && m)
            status = sample_movie_palette(context, m, image);
        cvol_image_free(image);
        status = agree_on_status(context, status);
    }
    return status;
}

static int add_frames(cvol_context *context, const film_of *f, movie *m, double *render_ms)
{
    const render_arguments *a = f->a;
    const int has_palette = m ? movie_needs_palette(m) : has_ending(a->output, ".gif");
    int status = has_palette ? sample_palette(context, f, m) : EXIT_DONE;
    for (int i = 0; i < a->turntable && !status; i++) {
        cvol_image *image;
        double ms = 0;
        override_progress(a->over_time ? "going through time" : "turning",
                          (double)i / a->turntable);
        status = take_frame(context, f, i, &image, &ms);
        *render_ms += ms;
        if (!status && m)
            status = add_to_movie(context, m, image);
        cvol_image_free(image);
        if (!status && was_interrupted())
            status = report_error(EXIT_FAILED, "cancelled");
        status = agree_on_status(context, status);
    }
    return status;
}

static int write_film(cvol_context *context, const film_of *f, double *render_ms)
{
    const render_arguments *a = f->a;
    const scene *s = f->s;
    const cvol_film_options options = {sizeof(cvol_film_options), a->fps, a->quality};
    int status = EXIT_DONE;
    movie *m = process_writes() ? open_movie(context, a->output, s->options.width,
                                             s->options.height, &options, &status)
                                : NULL;
    status = agree_on_status(context, status);
    if (!status)
        status = add_frames(context, f, m, render_ms);
    if (!status && m)
        return commit_movie(context, m);
    if (m)
        abandon_movie(m);
    return status;
}

static int digits_of(int count)
{
    int digits = 1;
    while (count >= 10) {
        count /= 10;
        digits++;
    }
    return digits;
}

static int write_frames(cvol_context *context, const film_of *f, double *render_ms)
{
    const render_arguments *a = f->a;
    int status = EXIT_DONE;
    for (int i = 0; i < a->turntable && !status; i++) {
        outcome result = {0};
        char *name = output_name(a->output, NULL, i + 1, digits_of(a->turntable));
        override_progress(a->over_time ? "going through time" : "turning",
                          (double)i / a->turntable);
        status = name ? set_frame(context, f, i) : report_error(EXIT_FAILED, "not enough memory");
        if (!status)
            status = write_pixels(context, f->s, a, name, &result);
        if (!status && was_interrupted())
            status = report_error(EXIT_FAILED, "cancelled");
        status = agree_on_status(context, status);
        *render_ms += result.render_ms;
        free(name);
    }
    return status;
}

int render_turntable(cvol_context *context, scene *s, render_arguments *a, const char *path,
                     turn_times *times)
{
    const film_of of = {s, a, path};
    const double start = milliseconds();
    double render_ms = 0;
    const int film = is_movie(a->output);
    int status = film ? write_film(context, &of, &render_ms)
                      : write_frames(context, &of, &render_ms);
    override_progress(NULL, 0);
    clear_progress();
    if (!status && !a->over_time)
        status = aim_camera(context, s, a, 0);
    if (status)
        return status;
    *times = (turn_times){render_ms / a->turntable, milliseconds() - start};
    return EXIT_DONE;
}

void print_turn(const scene *s, const render_arguments *a, const turn_times *times)
{
    printf("%s: %d pictures of %d x %d, loaded in %.0f ms, %.1f ms each to render, %.1f s in all\n",
           a->output, a->turntable, s->options.width, s->options.height, s->load_ms,
           times->frame_ms, 1e-3 * times->total_ms);
}

void describe_turn(json_t *object, const render_arguments *a, const turn_times *times)
{
    json_t *turn = json_pack("{s:i, s:f, s:f, s:f, s:I}", "frames", a->turntable, "fps", a->fps,
                             "frame_ms", times->frame_ms, "total_ms", times->total_ms, "film_bytes",
                             (json_int_t)(is_movie(a->output) ? file_size(a->output) : 0));
    if (turn)
        json_object_update(object, turn);
    json_decref(turn);
}
