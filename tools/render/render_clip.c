/* --clip and --clip-plane, and --eye. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/render/render_options.h"

/* ---- --clip ------------------------------------------------------------------------------------
 */

/* Reads one bound: empty, samples, or, with %, percent of the axis. Returns the text after it, or
 * NULL after an error. */
static const char *parse_bound(render_bound *bound, const char *text)
{
    char *end;
    *bound = (render_bound){0};
    if (*text == ':' || *text == ',' || !*text)
        return text;
    bound->value = strtod(text, &end);
    if (end == text || *text == ' ' || !isfinite(bound->value))
        return NULL;
    bound->kind = *end == '%' ? BOUND_PERCENT : BOUND_SAMPLES;
    return end + (*end == '%');
}

/* Reads X0:X1,Y0:Y1,Z0:Z1; each bound or axis may be empty. */
static int parse_clip(render_bound bounds[6], const char *text)
{
    for (int a = 0; a < 3; a++) {
        text = parse_bound(&bounds[2 * a], text);
        if (!text)
            return 0;
        if (*text == ':')
            text = parse_bound(&bounds[2 * a + 1], text + 1);
        else if (bounds[2 * a].kind) /* a single number */
            return 0;
        if (!text || *text != (a < 2 ? ',' : '\0'))
            return 0;
        text += a < 2;
    }
    return 1;
}

int check_clip(render_arguments *a)
{
    if (a->clip_text && !parse_clip(a->clip, a->clip_text))
        return report_error(
            EXIT_MISUSED,
            "--clip is '%s', must be X0:X1,Y0:Y1,Z0:Z1 in samples or percent, as in "
            "0:64,,25%%:75%%",
            a->clip_text);
    for (int k = 0; k < 3; k++) {
        const render_bound *from = &a->clip[2 * k], *to = from + 1;
        if (from->kind && from->kind == to->kind && !(from->value < to->value))
            return report_error(
                EXIT_MISUSED,
                "--clip is '%s': along %c it goes from %g to %g; the second number must "
                "be larger",
                a->clip_text, "xyz"[k], from -> value, to -> value);
    }
    for (int k = 0; k < a->clip_planes.count; k++)
        if (!parse_numbers(a->clip_plane[k], 4, a->clip_planes.texts[k]))
            return report_error(EXIT_MISUSED,
                                "--clip-plane is '%s', must be NX,NY,NZ,D, as in 1,0,1,-5",
                                a->clip_planes.texts[k]);
    return EXIT_DONE;
}

void set_clip(cvol_clip *clip, const render_arguments *a, const cvol_grid *grid)
{
    *clip = (cvol_clip){.planes = a->clip_planes.count};
    memcpy(clip->plane, a->clip_plane, sizeof clip->plane);
    for (int i = 0; i < 6; i++) {
        const render_bound *bound = &a->clip[i];
        const double unit = bound->kind == BOUND_PERCENT ? (double)(grid->dims[i / 2] - 1) / 100
                                                         : 1;
        double *to = i % 2 ? &clip->to[i / 2] : &clip->from[i / 2];
        *to = bound->kind ? bound->value * unit : i % 2 ? INFINITY : -INFINITY;
        if (bound->kind)
            clip->axes |= 1 << i / 2;
    }
}

/* ---- the eye ------------------------------------------------------------------------------------
 */

int check_eye(const render_arguments *a)
{
    const char *other = a->azimuth_given     ? "--azimuth"
                        : a->elevation_given ? "--elevation"
                        : a->view_name       ? "--view"
                        : a->zoom_given      ? "--zoom"
                        : a->turntable_given ? "--turntable"
                                             : NULL;
    if (a->up_given && !a->eye_given)
        return report_error(EXIT_MISUSED, "--up needs --eye");
    if (a->eye_given && !a->perspective_given)
        return report_error(EXIT_MISUSED, "--eye needs --perspective");
    if (a->eye_given && other)
        return report_error(EXIT_MISUSED, "give only one of --eye and %s", other);
    if (a->perspective_given && !(a->perspective >= 1 && a->perspective <= 150))
        return report_error(EXIT_MISUSED, "--perspective is %g, must be 1 to 150 degrees",
                            a->perspective);
    if (a->poses && (a->perspective_given || a->clip_text || a->clip_planes.count))
        return report_error(EXIT_MISUSED, "%s cannot be combined with --poses",
                            a->perspective_given ? "--perspective" : "--clip");
    return EXIT_DONE;
}

cvol_camera render_camera(const render_arguments *a, double turn_deg)
{
    cvol_camera camera = {.azimuth_deg = a->azimuth + turn_deg,
                          .elevation_deg = a->elevation,
                          .roll_deg = a->roll,
                          .zoom = a->zoom,
                          .fov_deg = a->perspective_given ? a->perspective : 0,
                          .placed = a->eye_given};
    memcpy(camera.eye, a->eye, sizeof camera.eye);
    memcpy(camera.look_at, a->look_at, sizeof camera.look_at);
    memcpy(camera.up, a->up, sizeof camera.up);
    return camera;
}
