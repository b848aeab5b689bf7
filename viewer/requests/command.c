/* The shell command that reproduces a picture byte for byte; for a copy, first the commands that
 * make the copy. It omits options with default values. */
#include "viewer/requests/command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/words/words.h"
#include "viewer/view/view.h"

/* ---- words ------------------------------------------------------------------------------------
 */

/* Writes the shortest text that reads back as this number. */
static void put_number(FILE *out, double value)
{
    char text[40];
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        const double back = strtod(text, NULL);
        if (!(back < value) && !(back > value))
            break;
    }
    fputs(text, out);
}

/* " --name a,b,c" */
static void put_numbers(FILE *out, const char *name, const double *values, int count)
{
    fprintf(out, " %s ", name);
    for (int i = 0; i < count; i++) {
        if (i)
            putc(',', out);
        put_number(out, values[i]);
    }
}

/* The same, unless the values are the defaults. */
static void put_other(FILE *out, const char *name, const double *values, const double *usual,
                      int count)
{
    int same = 1;
    for (int i = 0; i < count; i++)
        same = same && !(values[i] < usual[i]) && !(values[i] > usual[i]);
    if (!same)
        put_numbers(out, name, values, count);
}

/* Writes a word quoted for a shell. */
static void put_word(FILE *out, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "_./:+-,@%=";
    if (word[0] == '-') /* a file, not an option */
        fputs("./", out);
    if (*word && strspn(word, plain) == strlen(word)) {
        fputs(word, out);
        return;
    }
    putc('\'', out);
    for (; *word; word++)
        if (*word == '\'')
            fputs("'\\''", out);
        else
            putc(*word, out);
    putc('\'', out);
}

/* ---- volumes ----------------------------------------------------------------------------------
 */

/* The length of a file name without its extension. */
static int base_length(const char *name)
{
    const size_t length = strlen(name);
    if (length > 7 && !strcmp(name + length - 7, ".nii.gz"))
        return (int)length - 7;
    const char *dot = strrchr(name, '.');
    return dot && dot > name ? (int)(dot - name) : (int)length;
}

/* The number of channels of a compressed file. */
static int channels_of(const char *path)
{
    int channels = 1;
    cvol_context *context = cvol_context_create();
    cvol_series *series = NULL;
    if (context && !cvol_series_read(context, &series, path))
        channels = cvol_series_channels(series);
    cvol_series_free(series);
    cvol_context_free(context);
    return channels;
}

/* Writes the options of the viewer about its files. */
static void put_reading(FILE *out, const char *path, const shown_volume *v, int time,
                        int all_channels, const viewer_options *options)
{
    const cvol_read_options *read = &v->read;
    const int compressed = cvol_file_is_cvol(path);
    if (read->has_index)
        fprintf(out, " --time %d", read->index + time);
    if (!all_channels && (read->has_channel || (compressed && channels_of(path) > 1)))
        fprintf(out, " --channel %d", read->has_channel ? read->channel : 0);
    if (compressed)
        return;
    if (read->dims[0])
        fprintf(out, " --dims %zux%zux%zu", read->dims[0], read->dims[1], read->dims[2]);
    if (read->type)
        fprintf(out, " --type %s", cvol_type_name(read->type));
    if (read->big_endian)
        fputs(" --big-endian", out);
    if (read->spacing[0] > 0)
        put_numbers(out, "--spacing", read->spacing, 3);
    if (read->series) {
        fputs(" --series ", out);
        put_word(out, read->series);
    }
    if (options->has_fill)
        put_numbers(out, "--fill", &options->fill, 1);
}

/* The name of the file of a copy: NAME-ratio-60.cvol. */
static char *copy_name(const shown_volume *v)
{
    char *name = NULL;
    size_t size;
    FILE *out = open_memstream(&name, &size);
    if (!out)
        return NULL;
    fprintf(out, "%.*s", base_length(v->file), v->file);
    for (; v->parent; v = v->parent) {
        fputs(v->copy_options.target == CVOL_TARGET_PSNR ? "-psnr-" : "-ratio-", out);
        put_number(out, v->copy_options.target_value);
    }
    fputs(".cvol", out);
    return fclose(out) ? NULL : name;
}

/* The file of a volume; the caller frees it. */
static char *file_of(const shown_volume *v)
{
    return v->parent ? copy_name(v) : strdup(v->path);
}

/* Commands that make a copy, each with " && " behind it. 0: no memory. */
static int put_making(FILE *out, const shown_volume *v, const viewer_options *options)
{
    const shown_volume *parent = v->parent;
    if (!parent)
        return 1;
    char *from = file_of(parent), *to = file_of(v);
    const int good = from && to && put_making(out, parent, options);
    if (good) {
        fputs(parent->dense ? "cvol compress " : "cvol transcode ", out);
        put_word(out, from);
        putc(' ', out);
        put_word(out, to);
        put_numbers(out, v->copy_options.target == CVOL_TARGET_PSNR ? "--psnr" : "--ratio",
                    &v->copy_options.target_value, 1);
        if (!parent->dense || v->copy_options.target == CVOL_TARGET_RATIO)
            fputs(" --force", out); /* the viewer has no least PSNR */
        if (parent->dense)
            fputs(" --effort fast --background auto", out);
        if (v->flattened)
            fputs(" --background none", out);
        if (parent->dense && v->copy_options.has_fill)
            put_numbers(out, "--fill", &v->copy_options.fill, 1);
        if (!parent->parent)
            put_reading(out, from, parent, v->copied_time, 0, options);
        fputs(" && ", out);
    }
    free(from);
    free(to);
    return good;
}

/* ---- the view -----------------------------------------------------------------------------
 */

static const double none[4] = {0, 0, 0, 0};

static void put_camera(FILE *out, const view *v)
{
    const cvol_camera *c = &v->options.camera;
    const double one = 1;
    fprintf(out, " --size %dx%d --fit box", v->options.width, v->options.height);
    put_numbers(out, "--azimuth", &c->azimuth_deg, 1);
    put_numbers(out, "--elevation", &c->elevation_deg, 1);
    put_other(out, "--roll", &c->roll_deg, none, 1);
    put_other(out, "--zoom", &c->zoom, &one, 1);
    put_other(out, "--perspective", &c->fov_deg, none, 1);
    put_other(out, "--look-at", c->look_at, none, 3);
    if (v->mirror)
        fputs(" --mirror", out);
}

/* The direction of the light in the world, if it is given in the view. */
static void find_light(double light[3], const view *v)
{
    double q[4];
    memcpy(light, v->options.shading.light, 3 * sizeof *light);
    if (!v->options.illumination.in_view)
        return;
    const double right = v->options.illumination.in_view < 0 ? -light[0] : light[0];
    const double given[3] = {right, light[1], light[2]};
    cvol_camera_get_rotation(q, &v->options.camera);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double rows[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                               {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                               {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int a = 0; a < 3; a++)
        light[a] = rows[a][0] * given[0] + rows[a][1] * given[1] + rows[a][2] * given[2];
}

static void put_light(FILE *out, const view *v)
{
    const cvol_shading *s = &v->options.shading;
    const cvol_illumination *more = &v->options.illumination;
    cvol_render_options usual = cvol_render_options_defaults(), studio = usual;
    const int iso = v->options.mode == CVOL_MODE_ISO;
    double light[3];
    if (!iso && v->options.mode != CVOL_MODE_COMPOSITE)
        return;
    if (!iso && !s->on) {
        fputs(" --light flat", out);
        return;
    }
    if (more->samples)
        cvol_render_options_set_cinematic(&studio, 0);
    else
        cvol_render_options_set_studio(&studio);
    find_light(light, v);
    const int is_studio = more->in_view && more->keeps_brightness &&
                          !memcmp(s->light, studio.shading.light, sizeof s->light);
    if (is_studio)
        usual = studio;
    if (is_studio)
        fputs(more->samples ? " --light cinematic" : " --light studio", out);
    else if (!is_studio && (fabs(light[0]) > 0 || fabs(light[1]) > 0 || fabs(light[2]) > 0))
        put_numbers(out, "--light", light, 3);
    else if (!is_studio)
        fputs(" --light headlight", out);
    if (!is_studio && more->keeps_brightness)
        fputs(" --keep-brightness", out);
    const double shininess = s->shininess, usual_shininess = usual.shading.shininess;
    const double samples = more->samples, usual_samples = usual.illumination.samples;
    put_other(out, "--fill-light", &more->fill, &usual.illumination.fill, 1);
    put_other(out, "--occlusion", &more->occlusion, &usual.illumination.occlusion, 1);
    put_other(out, "--shadows", &more->shadows, &usual.illumination.shadows, 1);
    put_other(out, "--samples", &samples, &usual_samples, 1);
    put_other(out, "--ambient", &s->ambient, &usual.shading.ambient, 1);
    put_other(out, "--diffuse", &s->diffuse, &usual.shading.diffuse, 1);
    put_other(out, "--specular", &s->specular, &usual.shading.specular, 1);
    put_other(out, "--shininess", &shininess, &usual_shininess, 1);
    if (!iso)
        put_other(out, "--gradient-opacity", &s->gradient_opacity, none, 1);
}

/* 1 if the colour of a channel is not that of the file. */
static int has_own_colour(const view *channel)
{
    const double *rgb = channel->volume->channel.rgb;
    int own = 0;
    for (int k = 0; k < 3; k++)
        own = own || fabs(rgb[k] - channel->colour[k]) > 1e-9;
    return own;
}

/* 1 if the window of a component is not the range of its type. */
static int has_own_window(const view *channel)
{
    double range[2];
    cvol_component_get_range(range, channel->volume->grid.type);
    return memcmp(range, channel->options.window, sizeof range) != 0;
}

/* 1 if cvol render draws these channels: all that it draws of the file, in order, with one named
 * transfer function. */
static int are_usual_channels(const view *v)
{
    const viewer_channel *file = &v->volume->channel;
    /* Alpha is no dye. */
    const int without = file->is_component && file->count == 4 &&
                        strcmp(v->channels[0].transfer_name, VIEW_COMPONENT);
    int usual = v->options.mode == CVOL_MODE_COMPOSITE && v->volume->times == 1 &&
                v->channel_count == file->count - without;
    for (int c = 0; c < v->channel_count && usual; c++) {
        const view *one = &v->channels[c], *first = &v->channels[0];
        const double scale = one->opacity_scale - first->opacity_scale;
        usual = one->volume->channel.first == file->first && one->volume->channel.number == c &&
                one->transfer_name[0] && !(fabs(scale) > 0) &&
                !strcmp(one->transfer_name, first->transfer_name);
        if (!strcmp(one->transfer_name, VIEW_COMPONENT))
            usual = usual && file->is_component && !has_own_colour(one) && !has_own_window(one);
    }
    return usual;
}

static void put_channels(FILE *out, const view *v)
{
    const double one = 1;
    const char *name = v->channels[0].transfer_name;
    const int is_component = !strcmp(name, VIEW_COMPONENT);
    int is_own = v->volume->channel.is_component && !is_component;
    for (int c = 0; c < v->channel_count; c++)
        is_own = is_own || has_own_colour(&v->channels[c]);
    if (is_own)
        fputs(" --channel-colors '", out);
    for (int c = 0; c < v->channel_count && is_own; c++) {
        fputs(c ? ",#" : "#", out);
        for (int k = 0; k < 3; k++)
            fprintf(out, "%02x", (unsigned)(255 * v->channels[c].colour[k] + 0.5));
    }
    if (is_own)
        putc('\'', out);
    if (!is_component && strcmp(name, "microscopy"))
        fprintf(out, " --transfer %s", name);
    put_other(out, "--opacity-scale", &v->channels[0].opacity_scale, &one, 1);
}

/* 1 if samples mean other values. */
static int is_rescaled(const cvol_grid *grid)
{
    const double scale = grid->value_scale, offset = grid->value_offset;
    return fabs(scale) > 0 && (scale < 1 || scale > 1 || offset < 0 || offset > 0);
}

static void put_colours(FILE *out, const view *v)
{
    static const double as_stored[2] = {1, 0};
    const double one = 1, *rescale = v->volume->rescale;
    const cvol_grid *grid = &v->volume->grid;
    if (!v->transfer_name[0]) {
        fputs(" --transfer transfer.json", out);
        if (is_rescaled(grid)) /* its points are of samples */
            put_numbers(out, "--rescale", as_stored, 2);
    } else if (strcmp(v->transfer_name, "auto")) {
        fputs(" --transfer ", out);
        put_word(out, v->transfer_name);
    }
    if (v->transfer_name[0] && cvol_transfer_is_ct(v->transfer_name))
        put_numbers(out, "--rescale", fabs(rescale[0]) > 0 ? rescale : as_stored, 2);
    put_other(out, "--opacity-scale", &v->opacity_scale, &one, 1);
}

/* Windows and surfaces are sample values, not rescaled ones. */
static void put_values(FILE *out, const view *v)
{
    static const double as_stored[2] = {1, 0};
    const cvol_render_options *o = &v->options, usual = cvol_render_options_defaults();
    const double *w = o->window, window[2] = {w[0] + (w[1] - w[0]) / 2, w[1] - w[0]};
    fprintf(out, " --mode %s", word_of(&mode_words, (int)o->mode));
    double fitted[2];
    cvol_histogram_get_window(fitted, &v->volume->histogram);
    const int is_fitted = o->mode == CVOL_MODE_ISO && v->volume->times == 1 &&
                          !memcmp(fitted, w, sizeof fitted);
    const int windowed = !is_fitted && w[0] < w[1];
    if (windowed)
        put_numbers(out, "--window", window, 2);
    if (o->mode == CVOL_MODE_ISO) {
        put_numbers(out, "--iso", &o->surface.value, 1);
        put_other(out, "--iso-colour", o->surface.colour, usual.surface.colour, 3);
    }
    if ((windowed || o->mode == CVOL_MODE_ISO) && is_rescaled(&v->volume->grid))
        put_numbers(out, "--rescale", as_stored, 2);
}

/* --clip 10:,:20, and planes */
static void put_clip(FILE *out, const cvol_clip *clip)
{
    if (clip->axes)
        fputs(" --clip ", out);
    for (int a = 0; a < 3 && clip->axes; a++) {
        const int lower = clip->axes >> a & 1 && clip->from[a] > -1e29;
        const int upper = clip->axes >> a & 1 && clip->to[a] < 1e29;
        if (a)
            putc(',', out);
        if (lower)
            put_number(out, clip->from[a]);
        if (lower || upper)
            putc(':', out);
        if (upper)
            put_number(out, clip->to[a]);
    }
    for (int k = 0; k < clip->planes; k++)
        put_numbers(out, "--clip-plane", clip->plane[k], 4);
}

static void put_look(FILE *out, const view *v)
{
    const cvol_render_options *o = &v->options;
    const int composite = o->mode == CVOL_MODE_COMPOSITE, iso = o->mode == CVOL_MODE_ISO;
    const double one = 1;
    put_camera(out, v);
    if (composite && v->channel_count)
        put_channels(out, v);
    else if (composite)
        put_colours(out, v);
    else
        put_values(out, v);
    put_light(out, v);
    put_clip(out, &o->clip);
    put_other(out, "--background", o->background, none, 3);
    if (composite || iso || o->step_voxels >= 1) /* only these modes have finer steps */
        put_other(out, "--step", &o->step_voxels, none, 1);
    if (o->oversample > 0)
        put_other(out, "--oversample", &o->oversample, &one, 1);
    if (o->sheet.footprint != CVOL_SHEET_LINEAR)
        fprintf(out, " --footprint %s", word_of(&sheet_footprint_words, (int)o->sheet.footprint));
}

/* The labels of an overlay that are drawn. */
static void put_labels(FILE *out, const overlay_choice *choice, const viewer_overlay *given)
{
    int count = 0;
    if (choice->has_chosen)
        fputs(" --overlay-labels ", out);
    for (size_t k = 0; k < given->source->count && choice->has_chosen; k++)
        if (choice->chosen[k])
            fprintf(out, "%s%d", count++ ? "," : "", given->labels[k].value);
    if (!choice->has_chosen && given->labels_text) {
        fputs(" --overlay-labels ", out);
        put_word(out, given->labels_text);
    }
    if (given->label_file) {
        fputs(" --overlay-label-table ", out);
        put_word(out, given->label_file);
    }
}

static void put_overlay(FILE *out, const shown_volume *v, int i, const overlay_choice *choice)
{
    const viewer_overlay *given = overlays_given(v, i);
    const double one = 1, usual_depth = overlay_default_depth(&overlays_owner(v)->grid);
    const char *transfer = choice->transfer[0] ? choice->transfer : given->transfer;
    if (!overlays_is_drawn(choice, given))
        return;
    fputs(" --overlay ", out);
    put_word(out, given->source->path);
    if (transfer) {
        fputs(" --overlay-transfer ", out);
        put_word(out, transfer);
    }
    if (choice->has_window) {
        double rescale[2];
        overlay_get_rescale(rescale, given->source);
        const double *w = choice->window,
                     window[2] = {rescale[0] * (w[0] + (w[1] - w[0]) / 2) + rescale[1],
                                  fabs(rescale[0]) * (w[1] - w[0])};
        put_numbers(out, "--overlay-window", window, 2);
    }
    put_other(out, "--overlay-opacity", &choice->opacity, &one, 1);
    put_other(out, "--overlay-depth", &choice->depth, &usual_depth, 1);
    if (given->source->is_numbered)
        put_labels(out, choice, given);
}

/* NULL: no memory. */
static char *describe(const view *v, const viewer_options *options)
{
    char *text = NULL, *file = file_of(v->volume), *picture = NULL;
    size_t size, picture_size;
    FILE *name = open_memstream(&picture, &picture_size);
    if (name)
        fprintf(name, "%.*s.png", base_length(v->volume->file), v->volume->file);
    const int named = name && !fclose(name);
    FILE *out = open_memstream(&text, &size);
    int good = file && named && out && put_making(out, v->volume, options);
    if (good) {
        fputs("cvol render ", out);
        put_word(out, file);
        if (!v->volume->parent)
            put_reading(out, file, v->volume, v->time, v->channel_count > 0, options);
        fputs(" -o ", out);
        put_word(out, picture);
        put_look(out, v);
        for (int i = 0; i < v->overlay_count; i++)
            put_overlay(out, v->volume, i, &v->overlays[i]);
    }
    good = out && !fclose(out) && good;
    free(file);
    free(picture);
    if (good)
        return text;
    free(text);
    return NULL;
}

/* The control points of the view, as the content of a file. */
static json_t *files_of(const view *v)
{
    if (v->options.mode != CVOL_MODE_COMPOSITE || v->transfer_name[0])
        return json_object();
    json_t *points = json_array();
    for (size_t i = 0; i < v->point_count; i++) {
        const cvol_transfer_point *p = &v->points[i];
        json_array_append_new(points,
                              json_pack("[f, f, f, f, f]", p->value, p->r, p->g, p->b, p->opacity));
    }
    return json_pack("{s:{s:o}}", "transfer.json", "points", points);
}

/* The colours of a volume of several times fit all of them, so the command gets their points. */
static void fix_colours(view *v)
{
    cvol_context *context = v->volume->times > 1 && v->transfer_name[0] && !v->channel_count &&
                                    !view_shows_labels(v)
                                ? cvol_context_create()
                                : NULL;
    if (context)
        view_fix_colours(context, v);
    cvol_context_free(context);
}

answer command_post(request *r)
{
    char error[512] = "";
    json_t *body;
    view v = {0};
    fields_parse(&body, r->body, r->body_bytes, error, sizeof error);
    fields f = {body, NULL, "", error, sizeof error};
    int status = 400;
    if (body) {
        fields inner = take_object(&f, "view", "view.");
        if (!inner.object)
            fields_fail(&f, "view is missing: give the view of the picture");
        status = fields_ok(&f) ? view_take(&v, r->service->volumes, &inner) : 400;
        fields_end(&inner);
        fields_end(&f);
        if (!status && !fields_ok(&f))
            status = 400;
    }
    json_decref(body);
    if (!status && v.channel_count && !are_usual_channels(&v)) {
        fields_fail(&f,
                    "cvol render draws all channels of a file, in mode composite, with one named "
                    "transfer function: no command makes this picture");
        status = 400;
    }
    if (!status)
        fix_colours(&v);
    answer a = answer_error(status ? status : 500, "%s", error);
    if (!status) {
        char *text = describe(&v, r->service->options);
        answer_free(&a);
        json_t *object = text ? json_pack("{s:s, s:o}", "command", text, "files", files_of(&v))
                              : NULL;
        a = object ? answer_exact_json(200, object)
                   : answer_error(500, "cannot make the command: not enough memory, or a name "
                                       "that is not UTF-8");
        free(text);
    }
    view_free(&v);
    return a;
}
