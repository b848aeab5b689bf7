/* Axes, transformations and channels of OME-Zarr images. */
#include "volume/formats/zarr/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/io/unit.h"

static const char all_axes[] = "tczyx";

/* ---- groups -------------------------------------------------------------------------- */

static const json_t *first_multiscale(const cvol_zarr_group *group)
{
    return json_array_get(json_object_get(group->attributes, "multiscales"), 0);
}

static const json_t *dataset_of(const cvol_zarr_group *group, size_t level)
{
    return json_array_get(json_object_get(first_multiscale(group), "datasets"), level);
}

int cvol_zarr_group_open(cvol_context *context, cvol_zarr_group *group, int *is_group,
                         const char *folder)
{
    *group = (cvol_zarr_group){.attributes = NULL};
    *is_group = 0;
    int code = cvol_zarr_json_open(context, &group->json, folder, "zarr.json");
    if (code || group->json.root) {
        const char *kind = json_string_value(json_object_get(group->json.root, "node_type"));
        const json_t *attributes = json_object_get(group->json.root, "attributes");
        *is_group = kind && !strcmp(kind, "group");
        group->attributes = json_object_get(attributes, "ome");
        return code;
    }
    cvol_zarr_json mark;
    code = cvol_zarr_json_open(context, &mark, folder, ".zgroup");
    *is_group = mark.root != NULL;
    cvol_zarr_json_close(&mark);
    cvol_zarr_json_close(&group->json);
    if (!code)
        code = cvol_zarr_json_open(context, &group->json, folder, ".zattrs");
    group->attributes = group->json.root;
    *is_group = *is_group || first_multiscale(group) != NULL;
    return code;
}

void cvol_zarr_group_close(cvol_zarr_group *group)
{
    cvol_zarr_json_close(&group->json);
    group->attributes = NULL;
}

/* 1 if a path stays inside of its folder. */
static int stays_inside(const char *path)
{
    for (const char *part = path;; part++) {
        const size_t length = strcspn(part, "/");
        if (!length || (length <= 2 && !strncmp(part, "..", length)))
            return 0;
        part += length;
        if (!*part)
            return 1;
    }
}

int cvol_zarr_group_level(const cvol_zarr_group *group, size_t level, const char **path)
{
    const json_t *dataset = dataset_of(group, level), *value = json_object_get(dataset, "path");
    *path = json_string_value(value);
    if (!dataset || (*path && stays_inside(*path)))
        return CVOL_OK;
    return cvol_zarr_json_fail(&group->json, CVOL_ERROR_FORMAT, "path", value,
                               "must name an array inside of the folder");
}

int cvol_zarr_group_find(const cvol_zarr_group *group, const char *path)
{
    const json_t *datasets = json_object_get(first_multiscale(group), "datasets");
    for (size_t i = 0; i < json_array_size(datasets); i++) {
        const char *own = json_string_value(json_object_get(dataset_of(group, i), "path"));
        if (own && !strcmp(own, path))
            return (int)i;
    }
    return -1;
}

/* ---- axes ---------------------------------------------------------------------------- */

/* An axis is an object with a name, or a name (version 0.3). */
static int read_axes(cvol_zarr_image *image, const cvol_zarr_json *json, const json_t *axes)
{
    const size_t count = json_array_size(axes);
    const char *next = all_axes;
    int right = count >= 2 && count < sizeof all_axes;
    for (size_t i = 0; right && i < count; i++) {
        const json_t *axis = json_array_get(axes, i);
        const char *name = json_string_value(axis);
        const char *unit = json_string_value(json_object_get(axis, "unit"));
        if (!name)
            name = json_string_value(json_object_get(axis, "name"));
        next = name && name[0] && !name[1] ? strchr(next, name[0]) : NULL;
        right = next != NULL;
        if (!right)
            break;
        image->axis[i] = *next++;
        snprintf(image->unit[i], sizeof image->unit[i], "%s", unit ? unit : "");
    }
    image->rank = (int)count;
    if (right && image->axis[count - 2] == 'y' && image->axis[count - 1] == 'x')
        return CVOL_OK;
    return cvol_zarr_json_fail(json, CVOL_ERROR_UNSUPPORTED, "axes", axes,
                               "must be of t, c, z, y, x in this order, with y and x");
}

/* The numbers of a transformation, one for each axis; 0: they are none. */
static int read_numbers(double *out, const json_t *list, int count)
{
    int right = json_array_size(list) == (size_t)count;
    for (int i = 0; i < count && right; i++) {
        const json_t *entry = json_array_get(list, (size_t)i);
        out[i] = json_number_value(entry);
        right = json_is_number(entry) && isfinite(out[i]);
    }
    return right;
}

/* Applies scales and translations after those that the image has. */
static int transform(cvol_zarr_image *image, const cvol_zarr_json *json, const json_t *list)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        double numbers[CVOL_ZARR_AXES];
        const json_t *part = json_array_get(list, i);
        const char *kind = json_string_value(json_object_get(part, "type"));
        if (kind && !strcmp(kind, "identity"))
            continue;
        const int is_scale = kind && !strcmp(kind, "scale");
        int right = (is_scale || (kind && !strcmp(kind, "translation"))) &&
                    read_numbers(numbers, json_object_get(part, kind), image->rank);
        for (int a = 0; a < image->rank && right; a++) {
            right = !is_scale || numbers[a] > 0;
            image->scale[a] *= is_scale ? numbers[a] : 1;
            image->translation[a] = is_scale ? image->translation[a] * numbers[a]
                                             : image->translation[a] + numbers[a];
            right = right && isfinite(image->scale[a]) && isfinite(image->translation[a]);
        }
        if (!right)
            return cvol_zarr_json_fail(
                json, CVOL_ERROR_FORMAT, "coordinateTransformations", part,
                "must be a scale (positive) or a translation of one number for each axis");
    }
    return CVOL_OK;
}

int cvol_zarr_image_guess(cvol_zarr_image *image, int rank)
{
    const int most = (int)strlen(all_axes);
    *image = (cvol_zarr_image){.rank = rank};
    for (int a = 0; a < rank && rank <= most; a++) {
        image->axis[a] = all_axes[most - rank + a];
        image->scale[a] = 1;
    }
    return rank <= most;
}

int cvol_zarr_image_read(cvol_zarr_image *image, const cvol_zarr_group *group, size_t level)
{
    static const char key[] = "coordinateTransformations";
    const json_t *multiscale = first_multiscale(group);
    const json_t *axes = json_object_get(multiscale, "axes");
    cvol_zarr_image_guess(image, (int)strlen(all_axes));
    int code = axes ? read_axes(image, &group->json, axes) : CVOL_OK;
    if (!code)
        code = transform(image, &group->json, json_object_get(dataset_of(group, level), key));
    return code ? code : transform(image, &group->json, json_object_get(multiscale, key));
}

/* ---- geometry and labels ------------------------------------------------------------- */

/* Lengths are converted to the unit of x, if all axes have one. */
void cvol_zarr_image_place(cvol_grid *grid, const cvol_zarr_image *image)
{
    const char *spatial = "xyz", *unit[3] = {"", "", ""};
    double factor[3] = {1, 1, 1};
    char common[16];
    int known = 1;
    for (int k = 0; k < image->rank; k++) {
        const char *at = strchr(spatial, image->axis[k]);
        if (!at)
            continue;
        known = known && cvol_unit_of_length(image->unit[k], strlen(image->unit[k]));
        unit[at - spatial] = image->unit[k];
    }
    known = known && cvol_unit_factors(factor, common, unit);
    for (int k = 0; k < image->rank; k++) {
        const char *at = strchr(spatial, image->axis[k]);
        if (!at)
            continue;
        grid->spacing[at - spatial] = image->scale[k] * (known ? factor[at - spatial] : 1);
        grid->origin[at - spatial] = image->translation[k] * (known ? factor[at - spatial] : 1);
    }
    if (known)
        snprintf(grid->unit, sizeof grid->unit, "%s", common);
}

/* A colour as in "00FF7F". */
static void read_colour(cvol_channel_label *channel, const char *text)
{
    if (!text || strlen(text) != 6 || strspn(text, "0123456789abcdefABCDEF") != 6)
        return;
    const unsigned long value = strtoul(text, NULL, 16);
    channel->has_colour = 1;
    for (int k = 0; k < 3; k++)
        channel->colour[k] = (double)(value >> (16 - 8 * k) & 255) / 255;
}

int cvol_zarr_image_label(cvol_labels *labels, const cvol_zarr_image *image,
                          const cvol_zarr_group *group, size_t channels)
{
    for (int k = 0; k < image->rank; k++)
        if (image->axis[k] == 't' && image->unit[k][0]) {
            labels->time_step = image->scale[k];
            cvol_labels_set_unit(labels, image->unit[k], strlen(image->unit[k]));
        }
    const json_t *list = json_object_get(json_object_get(group->attributes, "omero"), "channels");
    if (!json_array_size(list))
        return 1;
    labels->channel = calloc(channels, sizeof *labels->channel);
    labels->channels = labels->channel ? channels : 0;
    for (size_t c = 0; c < labels->channels && c < json_array_size(list); c++) {
        const json_t *entry = json_array_get(list, c);
        const char *name = json_string_value(json_object_get(entry, "label"));
        if (name)
            cvol_labels_set_name(&labels->channel[c], name, strlen(name));
        read_colour(&labels->channel[c], json_string_value(json_object_get(entry, "color")));
    }
    return labels->channel != NULL;
}
