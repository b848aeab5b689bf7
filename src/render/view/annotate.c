/* Annotations (cvol/annotate.h): sizes, colours, and the scale bar. */
#include "render/view/annotate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/c_locale.h"
#include "base/context.h"
#include "base/options.h"
#include "image/pixels.h"
#include "render/view/options.h"

/* ---- lengths ---------------------------------------------------------------------------- */

double cvol_length_round(double most)
{
    const double power = pow(10, floor(log10(most) + 1e-9)), part = most / power * (1 + 1e-9);
    return power * (part >= 5 ? 5 : part >= 2 ? 2 : 1);
}

static const struct unit {
    const char *name, *shown;
    double metres;
} units[] = {{"nm", "nm", 1e-9}, {"um", "µm", 1e-6}, {"µm", "µm", 1e-6}, {"mm", "mm", 1e-3},
             {"cm", "cm", 1e-2}, {"m", "m", 1},      {"km", "km", 1e3}};

#define UNITS (sizeof units / sizeof *units)

static const struct unit *find_unit(const char *name)
{
    for (size_t i = 0; i < UNITS; i++)
        if (!strcmp(name, units[i].name))
            return &units[i];
    return NULL;
}

void cvol_length_format(char *text, size_t size, double length, const char *unit)
{
    const struct unit *known = find_unit(unit), *best = known;
    /* Its own unit, unless that needs a factor of a thousand or more, or a tenth or less. */
    for (size_t i = 0; known && i < UNITS; i++) {
        const double here = length * known->metres / units[i].metres;
        const double there = length * known->metres / best->metres;
        const int is_near = there >= 0.999 && there < 999.9;
        if (!is_near && here >= 0.999 && (there < 0.999 || here < there) &&
            strcmp(units[i].name, "cm"))
            best = &units[i];
    }
    const double shown = known ? length * known->metres / best->metres : length;
    snprintf(text, size, "%.6g%s%s", shown, *unit ? " " : "", known ? best->shown : unit);
}

/* Scanners measure in millimetres: where a volume has a patient's orientation but no unit, they are
 * assumed, and the text says so. */
static void format_scale(char *text, size_t size, double length, const cvol_grid *grid)
{
    const int assumed = !grid->unit[0] && grid->space != CVOL_SPACE_UNKNOWN;
    cvol_length_format(text, size, length, assumed ? "mm" : grid->unit);
    const size_t used = strlen(text);
    if (assumed)
        snprintf(text + used, size - used, " (assumed)");
}

void cvol_sketch_scale(const cvol_sketch *s)
{
    if (s->view.perspective) /* lengths differ with depth */
        return;
    char text[64];
    const double length = cvol_length_round(0.25 * s->view.width * s->view.pixel);
    const double pixels = length / s->view.pixel, tick = 0.45 * s->letter;
    const float x0 = (float)s->margin, x1 = (float)(s->margin + pixels);
    const float y = (float)(s->view.height - s->margin - tick), t = (float)tick;
    const cvol_segment bar[3] = {{x0, y, x1, y}, {x0, y - t, x0, y + t}, {x1, y - t, x1, y + t}};
    cvol_pen pen = s->pen;
    pen.width *= 1.4f;
    cvol_ink_halo(s->image, bar, 3, &pen);
    cvol_ink_stroke(s->image, bar, 3, &pen);
    format_scale(text, sizeof text, length, s->of->grid);
    double x = s->margin + (pixels - cvol_text_width(s->font, text)) / 2;
    x = x > s->margin ? x : s->margin;
    cvol_text_draw(s->image, s->font, text, x, (double)y - 1.1 * s->letter, &s->pen);
}

/* ---- all of it -------------------------------------------------------------------------- */

static void choose_pen(cvol_sketch *s, const double background[3], int transparent)
{
    const double luminance = 0.3 * background[0] + 0.59 * background[1] + 0.11 * background[2];
    s->is_bright = !transparent && luminance > 0.5;
    for (int c = 0; c < 3; c++) {
        s->pen.rgb[c] = s->is_bright ? 0.06f : 0.97f;
        s->pen.ground[c] = s->is_bright ? 1 : 0;
    }
    s->pen.width = (float)fmax(s->letter / 9, 1.1);
    s->pen.halo = (float)fmax(s->letter / 8, 1);
    s->pen.opacity = 1;
    s->pen.ground_opacity = 0.6f;
}

static void draw(cvol_sketch *s, const cvol_render_options *options)
{
    choose_pen(s, options->background, s->of->transparent);
    cvol_sketch_scale(s);
    cvol_sketch_axes(s);
    if (options->mode != CVOL_MODE_ISO)
        cvol_sketch_values(s);
}

int cvol_image_annotate(cvol_context *context, cvol_image *image, const cvol_annotation *of)
{
    cvol_annotation full = {.size = sizeof(cvol_annotation)};
    cvol_render_options options;
    cvol_sketch s = {.image = image, .of = &full};
    int code = cvol_options_copy(context, &full, sizeof full,
                                 CVOL_SIZE_TO(cvol_annotation, value_unit), "cvol_annotation", of);
    if (!code)
        code = cvol_render_options_complete(context, &options, full.options);
    full.options = &options;
    if (!code)
        code = cvol_image_need_floats(context, image, "annotating");
    if (!code)
        code = cvol_view_make(context, &s.view, full.grid, &options);
    if (code)
        return code;
    if (image->width != s.view.width || image->height != s.view.height)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "annotating: the picture has %d x %d pixels, the options say %d x %d",
                         image->width, image->height, s.view.width, s.view.height);
    const double size = fmin(image->width, image->height);
    s.letter = fmax(round(0.021 * size), 8);
    s.margin = fmax(0.022 * size, 4);
    s.grey = cvol_mode_is_grey(options.mode);
    cvol_c_locale locale;
    code = cvol_c_locale_enter(context, &locale);
    if (code)
        return code;
    code = cvol_font_open(context, &s.font, s.letter);
    if (!code)
        draw(&s, &options);
    cvol_font_free(s.font);
    cvol_c_locale_leave(&locale);
    return code;
}
