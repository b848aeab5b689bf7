/* Light: from the options to shading and illumination. */
#include <string.h>

#include "tools/render/render_options.h"

static int can_have_studio(const scene *s)
{
    return s->engine == CVOL_ENGINE_SHEET || s->engine == CVOL_ENGINE_RAY;
}

static int is_lit_mode(const scene *s)
{
    return s->options.mode == CVOL_MODE_COMPOSITE || s->options.mode == CVOL_MODE_ISO;
}

/* The light when the options choose none. */
static int default_light(const scene *s, const render_arguments *a)
{
    if (a->shade)
        return LIGHT_HEADLIGHT;
    if (a->has_default_look && !a->certify && can_have_studio(s) && is_lit_mode(s))
        return LIGHT_STUDIO;
    return s->options.mode == CVOL_MODE_ISO ? LIGHT_HEADLIGHT : LIGHT_FLAT;
}

/* Reads --light. Exit status. */
static int choose_kind(int *kind, render_arguments *a, const scene *s)
{
    *kind = default_light(s, a);
    if (!a->light_text || find_word(kind, &light_words, a->light_text))
        return EXIT_DONE;
    if (!parse_numbers(a->light, 3, a->light_text))
        return report_error(
            EXIT_MISUSED,
            "--light is '%s', must be studio, cinematic, headlight, flat, or a direction "
            "X,Y,Z, as in 1,-1,2",
            a->light_text);
    *kind = LIGHT_DIRECTION;
    if (a->light[0] == 0 && a->light[1] == 0 && a->light[2] == 0)
        return report_error(EXIT_MISUSED, "--light is 0,0,0, must be a direction");
    for (int k = 0; k < 3; k++)
        if (!(a->light[k] >= -1e30 && a->light[k] <= 1e30))
            return report_error(EXIT_MISUSED, "--light has %g, each must be within -1e30 and 1e30",
                                a->light[k]);
    return EXIT_DONE;
}

/* Refuses light where there is none. Exit status. */
static int check_light(const scene *s, const render_arguments *a, int kind, const char *given)
{
    const int is_surface = s->options.mode == CVOL_MODE_ISO;
    const char *asked = a->shade                              ? "--shade"
                        : a->light_text && kind != LIGHT_FLAT ? "--light"
                                                              : given;
    if (kind == LIGHT_FLAT && (a->shade || given))
        return report_error(EXIT_MISUSED, "%s needs a light: %s", a->shade ? "--shade" : given,
                            a->light_text ? "leave out --light flat"
                                          : "give --light headlight or X,Y,Z");
    if (a->shade && a->light_text && (kind == LIGHT_STUDIO || kind == LIGHT_CINEMATIC))
        return report_error(EXIT_MISUSED, "give only one of --shade and --light %s", a->light_text);
    if (asked && s->engine == CVOL_ENGINE_FOURIER)
        return report_error(
            EXIT_MISUSED, "%s does not work with engine fourier, which has mode xray only", asked);
    if (asked && !is_lit_mode(s))
        return report_error(EXIT_MISUSED, "%s works only in modes composite and iso, not in %s",
                            asked, a->mode_name);
    if (is_surface && kind == LIGHT_FLAT)
        return report_error(EXIT_MISUSED, "--light flat works only in mode composite: a surface "
                                          "without light has no shape");
    if (a->gradient_opacity_given && is_surface)
        return report_error(EXIT_MISUSED,
                            "--gradient-opacity works only in mode composite: surfaces "
                            "are opaque");
    const char *of_volume = kind == LIGHT_STUDIO      ? "--light studio"
                            : kind == LIGHT_CINEMATIC ? "--light cinematic"
                            : a->occlusion_given      ? "--occlusion"
                            : a->shadows_given        ? "--shadows"
                            : a->samples_given        ? "--samples"
                            : a->keep_brightness      ? "--keep-brightness"
                                                      : NULL;
    const char *illumination = of_volume ? of_volume : a->fill_light_given ? "--fill-light" : NULL;
    if (illumination && !can_have_studio(s))
        return report_error(EXIT_MISUSED, "%s works only with engines sheet and ray", illumination);
    if (a->certify && of_volume)
        return report_error(EXIT_MISUSED,
                            "%s cannot be combined with --certify: its light depends on the "
                            "samples of the whole volume",
                            of_volume);
    return EXIT_DONE;
}

const char *find_light_detail(const render_arguments *a)
{
    return a->shininess_given          ? "--shininess"
           : a->samples_given          ? "--samples"
           : a->keep_brightness        ? "--keep-brightness"
           : a->ambient_given          ? "--ambient"
           : a->diffuse_given          ? "--diffuse"
           : a->specular_given         ? "--specular"
           : a->gradient_opacity_given ? "--gradient-opacity"
           : a->fill_light_given       ? "--fill-light"
           : a->occlusion_given        ? "--occlusion"
           : a->shadows_given          ? "--shadows"
                                       : NULL;
}

void drop_default_light(scene *s, const render_arguments *a)
{
    const int asked = a->light_text || a->shade || find_light_detail(a);
    if (asked || s->options.mode != CVOL_MODE_COMPOSITE || !cvol_transfer_is_opaque(s->transfer))
        return;
    s->options.shading.on = 0;
    s->options.illumination = (cvol_illumination){0};
}

int choose_light(scene *s, render_arguments *a)
{
    cvol_shading *shading = &s->options.shading;
    cvol_illumination *more = &s->options.illumination;
    int kind;
    int status = choose_kind(&kind, a, s);
    if (status)
        return status;
    if (kind == LIGHT_STUDIO)
        cvol_render_options_set_studio(&s->options);
    if (kind == LIGHT_CINEMATIC)
        cvol_render_options_set_cinematic(&s->options, 0);
    shading->on = kind != LIGHT_FLAT && s->options.mode == CVOL_MODE_COMPOSITE;
    if (kind == LIGHT_DIRECTION)
        memcpy(shading->light, a->light, sizeof shading->light);
    const struct {
        const char *name;
        int given;
        double value, least, most;
        double *out;
    } numbers[] = {
        {"--ambient", a->ambient_given, a->ambient, 0, 10, &shading->ambient},
        {"--diffuse", a->diffuse_given, a->diffuse, 0, 10, &shading->diffuse},
        {"--specular", a->specular_given, a->specular, 0, 10, &shading->specular},
        {"--gradient-opacity", a->gradient_opacity_given, a->gradient_opacity, 1e-30, 1e30,
         &shading->gradient_opacity},
        {"--fill-light", a->fill_light_given, a->fill_light, 0, 10, &more->fill},
        {"--occlusion", a->occlusion_given, a->occlusion, 0, 1, &more->occlusion},
        {"--shadows", a->shadows_given, a->shadows, 0, 1, &more->shadows},
    };
    const int count = sizeof numbers / sizeof *numbers;
    if ((status = check_light(s, a, kind, find_light_detail(a))))
        return status;
    for (int k = 0; k < count; k++) {
        if (!numbers[k].given)
            continue;
        if (!(numbers[k].value >= numbers[k].least && numbers[k].value <= numbers[k].most))
            return report_error(EXIT_MISUSED, "%s is %g, must be %g to %g", numbers[k].name,
                                numbers[k].value, numbers[k].least, numbers[k].most);
        *numbers[k].out = numbers[k].value;
    }
    if (a->shininess_given && (a->shininess < 1 || a->shininess > 256))
        return report_error(EXIT_MISUSED, "--shininess is %d, must be 1 to 256", a->shininess);
    if (a->samples_given && (a->samples < 2 || a->samples > 65536))
        return report_error(EXIT_MISUSED, "--samples is %d, must be 2 to 65536", a->samples);
    if (a->samples_given)
        more->samples = a->samples;
    if (a->shininess_given)
        shading->shininess = a->shininess;
    more->keeps_brightness |= a->keep_brightness;
    return EXIT_DONE;
}
