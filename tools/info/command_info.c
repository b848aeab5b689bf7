/* cvol info: describes volumes, .cvol files and this build. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "build_lacks.h"
#include "tools/base/picture.h"
#include "tools/info/info.h"
#include "tools/labels/labels.h"

static const char description[] =
    "Prints shape, sample type, geometry and value range of a volume. For a .cvol file and\n"
    "for a compressed picture it also prints how it is compressed, and a certified bound of\n"
    "its error. For a volume of labels it lists them, with the number of samples and the volume\n"
    "of each. For a file of several volumes it lists times and channels, or describes the volume "
    "that --time\n"
    "and --channel choose. --layout prints the sections of a .cvol file; exit status 1: a\n"
    "section is damaged.";

json_t *describe_grid(const cvol_grid *grid)
{
    json_t *directions = json_pack("[o, o, o]", json_triple(grid->direction[0]),
                                   json_triple(grid->direction[1]),
                                   json_triple(grid->direction[2]));
    return json_pack("{s:o, s:s, s:o, s:o, s:o, s:s, s:o, s:[f, f]}", "dims", json_dims(grid->dims),
                     "type", cvol_type_name(grid->type), "spacing", json_triple(grid->spacing),
                     "origin", json_triple(grid->origin), "directions", directions, "space",
                     word_of(&space_words, (int)grid->space), "unit", json_text(grid->unit),
                     "rescale", grid->value_scale, grid->value_offset);
}

/* The attributes as JSON, or null. */
static json_t *describe_attributes(const cvol_array *array)
{
    const char *text = cvol_array_attributes(array);
    json_t *value = text ? json_loads(text, JSON_DECODE_ANY | JSON_ALLOW_NUL, NULL) : NULL;
    return value ? value : text ? json_text(text) : json_null();
}

static json_t *describe_array(const input *in)
{
    const cvol_array *array = in->array;
    const uint64_t file_bytes = in->file_bytes;
    const cvol_grid *grid = cvol_array_grid(array);
    cvol_array_info info;
    cvol_array_get_info(&info, array);
    json_t *object = describe_grid(grid);
    json_t *more = json_pack(
        "{s:f, s:f, s:i, s:s, s:i, s:o, s:f, s:I, s:f, s:f, s:f, s:I, s:I, s:o, s:o, s:b, s:o, "
        "s:o, s:o, "
        "s:o, s:f, s:f, s:b, s:i, s:b, s:o, s:I, s:I, s:o, s:b}",
        "min", info.value_min, "max", info.value_max, "rank", info.rank, "transform",
        cvol_transform_name(info.transform), "block", info.block, "low", json_dims(info.low),
        "step", info.step, "coefficients", (json_int_t)info.coefficients, "rho", info.rho, "ratio",
        (double)cvol_grid_bytes(grid) / (double)file_bytes, "bits_per_voxel",
        8 * (double)file_bytes / (double)cvol_grid_samples(grid), "file_bytes",
        (json_int_t)file_bytes, "resident_bytes", (json_int_t)info.resident_bytes, "psnr_db",
        json_decibels(info.psnr_db), "max_error", json_number(info.max_error), "measured",
        info.measured, "l2_error", json_number(info.l2_error), "rms_bound",
        json_number(rms_bound(&info, grid)), "point_error", json_number(info.point_error),
        "max_abs", json_number(info.max_abs), "value_min", info.value_min, "value_max",
        info.value_max, "whole", !in->cut, "level", in->level, "residual_missing",
        in->residual_missing, "background",
        info.background_samples ? json_real(info.background) : json_null(), "background_samples",
        (json_int_t)info.background_samples, "missing_samples", (json_int_t)info.missing_samples,
        "brick", info.brick[0] ? json_dims(info.brick) : json_null(), "exact",
        is_exact(info.psnr_db));
    json_object_update(object, more);
    json_decref(more);
    return object;
}

static json_t *describe_volume(cvol_context *context, const cvol_volume *volume,
                               uint64_t file_bytes)
{
    cvol_volume_statistics stats;
    if (cvol_volume_compute_statistics(context, &stats, volume))
        return NULL;
    json_t *object = describe_grid(&volume->grid);
    json_t *more = json_pack("{s:o, s:o, s:o, s:I, s:I}", "min", json_number(stats.min), "max",
                             json_number(stats.max), "mean", json_number(stats.mean),
                             "nan_or_infinite", (json_int_t)stats.bad_count, "file_bytes",
                             (json_int_t)file_bytes);
    json_object_update(object, more);
    json_decref(more);
    return object;
}

/* The name of a key in the text output. */
static const char *label_of(const char *key)
{
    return !strcmp(key, "l2_error")      ? "error bound (L2)"
           : !strcmp(key, "rms_bound")   ? "... RMS"
           : !strcmp(key, "point_error") ? "... every sample"
                                         : key;
}

/* Prints one line per field, in the order of the object. The PSNR of an exact file is "exact". */
void print_fields(json_t *object)
{
    const char *key;
    json_t *value;
    if (json_is_true(json_object_get(object, "exact")))
        json_object_set_new(object, "psnr_db", json_string("exact"));
    json_object_del(object, "exact");
    json_object_foreach(object, key, value)
    {
        printf("  %-16s ", label_of(key));
        if (json_is_string(value))
            printf("%s\n", json_string_value(value));
        else {
            char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(7));
            printf("%s\n", text ? text : "?");
            free(text);
        }
    }
}

/* Millimetres are assumed where annotations assume them (cvol_image_annotate). */
static void name_assumed_unit(json_t *object)
{
    const char *unit = json_string_value(json_object_get(object, "unit")),
               *space = json_string_value(json_object_get(object, "space"));
    if (unit && !*unit && space && strcmp(space, word_of(&space_words, CVOL_SPACE_UNKNOWN)))
        json_object_set_new(object, "unit", json_string("mm (assumed)"));
}

static void print_text(const char *path, json_t *object)
{
    name_assumed_unit(object);
    clear_progress();
    printf("%s\n", path);
    print_fields(object);
}

/* The libraries that this build lacks. */
static json_t *list_lacks(void)
{
    json_t *list = json_array();
    for (size_t i = 0; build_lacks[i]; i++)
        json_array_append_new(list, json_string(build_lacks[i]));
    return list;
}

static int describe_build(int json)
{
#ifdef CVOL_HAVE_VIEWER
    const int viewer = 1;
#else
    const int viewer = 0;
#endif
    char engines[WORD_LIST], transforms[WORD_LIST];
    json_t *object = json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:b, s:o}", "version",
                               cvol_version(), "reads", cvol_volume_readers(), "formats",
                               cvol_volume_formats(), "films", cvol_film_formats(), "engines",
                               list_words(engines, &engine_words, " ", " "), "transforms",
                               list_words(transforms, &transform_words, " ", " "), "viewer", viewer,
                               "lacks", list_lacks());
    if (json)
        return print_json(object);
    json_object_del(object, "lacks");
    print_text("cvol", object);
    json_decref(object);
    for (size_t i = 0; build_lacks[i]; i++)
        printf("  %-16s %s\n", "built without", build_lacks[i]);
    return EXIT_DONE;
}

/* Describes a compressed picture. */
static int show_picture(cvol_context *context, const common_options *common, const char *path)
{
    cvol_picture *picture;
    cvol_picture_info info;
    if (has_raw_options(common) || common->fill_given)
        return report_error(
            EXIT_MISUSED,
            "%s: is a compressed picture: leave out --dims, --type and other options for "
            "raw samples",
            path);
    int code = cvol_picture_read(context, &picture, path);
    if (!code)
        code = cvol_picture_get_info(context, &info, picture);
    cvol_picture_free(picture);
    if (code)
        return report_context_error(context, code, NULL);
    json_t *object = describe_picture(&info);
    if (common->json || !object)
        return print_json(object);
    print_text(path, object);
    json_decref(object);
    return EXIT_DONE;
}

static json_t *describe_baked(const cvol_baked_info *info, const char *path)
{
    const uint64_t bytes = file_size(path);
    const cvol_grid *grid = &info->grid;
    json_t *points = json_array();
    for (size_t i = 0; i < info->transfer_count; i++) {
        const cvol_transfer_point *p = &info->transfer_points[i];
        json_array_append_new(points,
                              json_pack("[f, f, f, f, f]", p->value, p->r, p->g, p->b, p->opacity));
    }
    return json_pack(
        "{s:s, s:o, s:s, s:o, s:s, s:i, s:i, s:i, s:s, s:i, s:s, s:o, s:b, s:o, s:s, s:i, s:f, "
        "s:f, s:f, s:f, s:I, s:f, s:I, s:I}",
        "kind", "baked", "dims", json_dims(grid->dims), "type", cvol_type_name(grid->type),
        "spacing", json_triple(grid->spacing), "axis", word_of(&axis_words, info->axis), "slices",
        (int)info->slices, "visible_slices", (int)info->visible, "channels", info->channels,
        "transform", cvol_transform_name(info->transform), "tile", info->tile, "transfer",
        info->transfer_name, "transfer_points", points, "lit", info->shading.on, "light",
        json_triple(info->shading.light), "footprint",
        word_of(&footprint_words, (int)info->splat.footprint), "footprint_size", info->splat.size,
        "sigma", info->splat.sigma, "rho", info->rho, "kept", info->kept, "step", info->step,
        "coefficients", (json_int_t)info->terms, "ratio",
        (double)cvol_grid_bytes(grid) / (double)bytes, "file_bytes", (json_int_t)bytes,
        "resident_bytes", (json_int_t)info->resident_bytes);
}

/* Describes a baked volume. */
static int show_baked(cvol_context *context, const common_options *common, const char *path)
{
    cvol_renderer *renderer = NULL;
    cvol_baked_info info;
    if (has_raw_options(common) || common->fill_given)
        return report_error(EXIT_MISUSED,
                            "%s: is a baked volume: leave out --dims, --type and other options for "
                            "raw samples",
                            path);
    int code = cvol_renderer_create(context, &renderer, CVOL_ENGINE_TRANSFORM,
                                    CVOL_SOURCE(.baked_path = path));
    if (!code)
        code = cvol_renderer_get_baked_info(context, &info, renderer);
    json_t *object = code ? NULL : describe_baked(&info, path);
    cvol_renderer_free(renderer);
    if (code)
        return report_context_error(context, code, NULL);
    if (common->json || !object)
        return print_json(object);
    json_object_del(object, "transfer_points");
    print_text(path, object);
    json_decref(object);
    return EXIT_DONE;
}

/* Describes an open volume. Exit status. */
static int show_volume(cvol_context *context, const common_options *common, input *in,
                       const char *label_file, const char *path)
{
    json_t *labels = NULL;
    json_t *object = in->array ? describe_array(in)
                               : describe_volume(context, in->volume, in->file_bytes);
    int status = object ? list_labels_of(context, &labels, in, label_file, path)
                        : report_error(EXIT_FAILED, "not enough memory to describe %s", path);
    if (!status && common->json) {
        if (in->array)
            json_object_set_new(object, "attributes", describe_attributes(in->array));
        if (labels)
            json_object_set(object, "labels", labels);
        status = print_json(json_incref(object));
    } else if (!status) {
        print_text(path, object);
        if (in->array && cvol_array_attributes(in->array))
            printf("  %-16s %s\n", "attributes", cvol_array_attributes(in->array));
        if (labels)
            print_label_list(labels, input_grid(in));
    }
    json_decref(labels);
    json_decref(object);
    return status;
}

static int describe(cvol_context *context, common_options *common, const char *label_file,
                    const char *path)
{
    input in;
    if (kind_of(path) == CVOL_FILE_SERIES && !common->read.has_index && !common->read.has_channel)
        return show_series(context, common, path);
    if (kind_of(path) == CVOL_FILE_BAKED)
        return show_baked(context, common, path);
    if (kind_of(path) == CVOL_FILE_PICTURE)
        return show_picture(context, common, path);
    if (!is_cvol(path)) {
        int times, channels;
        const int status = count_volumes(context, common, path, &times, &channels);
        if (status || times > 1 || channels > 1)
            return status ? status : show_several(context, common, path, times, channels);
    }
    common->accept_cut = 1;
    int status = open_input(context, &in, path, common);
    if (!status)
        status = show_volume(context, common, &in, label_file, path);
    close_input(&in);
    return status;
}

/* ---- the sections of a file ------------------------------------------------------------------ */

static json_t *describe_layout(const cvol_file_layout *layout)
{
    json_t *sections = json_array();
    for (int i = 0; i < layout->section_count; i++) {
        const cvol_file_section *s = &layout->sections[i];
        json_array_append_new(sections,
                              json_pack("{s:s, s:b, s:I, s:I, s:s, s:s}", "tag", s->tag, "required",
                                        s->flags & 1, "offset", (json_int_t)s->offset, "length",
                                        (json_int_t)s->length, "checksum",
                                        cvol_section_state_name(s->state), "content", s->content));
    }
    return json_pack("{s:I, s:I, s:o, s:o}", "file_bytes", (json_int_t)layout->file_bytes,
                     "version", (json_int_t)layout->version, "level",
                     layout->level < 0 ? json_null() : json_integer(layout->level), "sections",
                     sections);
}

static void print_layout(const char *path, const cvol_file_layout *layout)
{
    printf("%s: version %u, %llu bytes\n", path, layout->version,
           (unsigned long long)layout->file_bytes);
    printf("  %-4s  %12s  %12s  %-11s  %s\n", "tag", "offset", "length", "checksum", "content");
    for (int i = 0; i < layout->section_count; i++) {
        const cvol_file_section *s = &layout->sections[i];
        printf("  %-4s  %12llu  %12llu  %-11s  %s\n", s->tag, (unsigned long long)s->offset,
               (unsigned long long)s->length, cvol_section_state_name(s->state), s->content);
    }
}

/* Prints the sections of a damaged file too; only of a .cvol file. */
static int show_layout(cvol_context *context, const common_options *common, const char *path)
{
    cvol_file_layout layout;
    if (has_raw_options(common) || common->fill_given)
        return report_error(EXIT_MISUSED,
                            "--layout reads .cvol files: leave out --dims, --type and "
                            "other options for raw samples");
    int code = cvol_file_read_layout(context, &layout, path);
    if (code != CVOL_OK && code != CVOL_ERROR_CORRUPT)
        return report_context_error(context, code, NULL);
    clear_progress();
    int status = EXIT_DONE;
    if (common->json)
        status = print_json(describe_layout(&layout));
    else
        print_layout(path, &layout);
    return code ? report_context_error(context, code, NULL) : status;
}

int command_info(int argc, char **argv)
{
    common_options common = COMMON_DEFAULTS;
    int build = 0, layout = 0;
    const char *label_file = NULL;
    const option_spec specs[] = {
        {"--build", NULL, "describe this build of cvol instead of a file", OPTION_FLAG, &build, 0,
         NULL},
        {"--layout", NULL, "list the sections of a .cvol file and check their checksums",
         OPTION_FLAG, &layout, 0, NULL},
        {"--label-table", "FILE", "names of labels: a file of ITK-SNAP, FreeSurfer or 3D Slicer",
         OPTION_TEXT, &label_file, 0, NULL},
        INPUT_OPTIONS(common),
        COMMON_OPTIONS(common),
    };
    command_line line = {.usage = "cvol info FILE [options]",
                         .description = description,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 1};
    for (int i = 1; i < argc; i++)
        if (!strcmp(argv[i], "--build"))
            line.positional_count = 0;
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0)
        return status;
    cvol_context *context = begin_command(&common);
    if (!context)
        return EXIT_FAILED;
    const char *path = line.positionals[0];
    status = build    ? describe_build(common.json)
             : layout ? show_layout(context, &common, path)
                      : describe(context, &common, label_file, path);
    return end_command(context, status);
}
