/* A folder of pictures, PNG or JPEG, as the slices of a volume, in natural order of their names:
 * grey levels of 8 or 16 bits, or the channels of colours. Other files in the folder are left out;
 * reader.c asks only for folders without volumes of other formats. */
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "base/grid.h"
#include "volume/formats/pictures/picture.h"
#include "volume/io/folder.h"
#include "volume/io/format.h"
#include "volume/io/strided.h"

typedef enum kind { OTHER, PNG, JPEG } kind;

static kind kind_of(const char *path)
{
    static const uint8_t png[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    cvol_context context = {.limit_bytes = UINT64_MAX}; /* for discarded messages */
    uint8_t head[sizeof png] = {0};
    size_t size;
    if (cvol_file_peek(&context, head, &size, sizeof head, path))
        return OTHER;
    if (!memcmp(head, png, sizeof png))
        return PNG;
    return head[0] == 0xff && head[1] == 0xd8 && head[2] == 0xff ? JPEG : OTHER;
}

static int recognise_folder(const char *path)
{
    cvol_context context = {.limit_bytes = UINT64_MAX};
    cvol_folder folder;
    int is_found = 0;
    if (!cvol_folder_open(&context, &folder, path))
        for (size_t i = 0; i < folder.count && !is_found; i++)
            is_found = kind_of(folder.paths[i]) != OTHER;
    cvol_folder_close(&folder);
    return is_found;
}

typedef struct stack {
    cvol_folder files;
    cvol_picture first; /* the shape that all must have; without pixels */
    int channel;
} stack;

static void close_stack(void *state)
{
    stack *s = state;
    if (!s)
        return;
    cvol_folder_close(&s->files);
    free(s);
}

int cvol_picture_check(cvol_context *context, const cvol_picture *picture, const char *path)
{
    const uint64_t pixel = (uint64_t)picture->channels * (uint64_t)picture->bits / 8;
    if (!picture->width || !picture->height)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: has %zu x %zu pixels", path,
                         picture->width, picture->height);
    if (picture->width > cvol_context_limit_bytes(context) / picture->height / pixel)
        return cvol_fail(context, CVOL_ERROR_LIMIT,
                         "%s: %zu x %zu pixels of %d bytes are more than the limit of %llu bytes",
                         path, picture->width, picture->height, (int)pixel,
                         (unsigned long long)cvol_context_limit_bytes(context));
    return CVOL_OK;
}

static int read_picture(cvol_context *context, cvol_picture *out, const char *path)
{
    return kind_of(path) == PNG ? cvol_picture_read_png(context, out, path)
                                : cvol_picture_read_jpeg(context, out, path);
}

static int read_slice(cvol_context *context, const stack *s, size_t number, uint8_t *out)
{
    const cvol_picture *first = &s->first;
    const char *path = s->files.paths[number];
    cvol_picture picture;
    int code = read_picture(context, &picture, path);
    if (code)
        return code;
    if (picture.width != first->width || picture.height != first->height ||
        picture.channels != first->channels || picture.bits != first->bits)
        code = cvol_fail(
            context, CVOL_ERROR_FORMAT,
            "%s: has %zu x %zu pixels of %d x %d bits, but %s has %zu x %zu of %d x %d "
            "bits",
            path, picture.width, picture.height, picture.channels, picture.bits, s->files.paths[0],
            first->width, first->height, first->channels, first->bits);
    const size_t sample = (size_t)first->bits / 8, step = sample * (size_t)first->channels;
    if (!code)
        cvol_strided_gather(out, picture.pixels + sample * (size_t)s->channel,
                            first->width * first->height, step, sample, 0);
    free(picture.pixels);
    return code;
}

static int read_slices(cvol_context *context, void *state, void *out, size_t first, size_t count)
{
    const stack *s = state;
    const size_t bytes = s->first.width * s->first.height * (size_t)s->first.bits / 8;
    int code = CVOL_OK;
    for (size_t z = 0; z < count && !code; z++)
        code = read_slice(context, s, first + z, (uint8_t *)out + z * bytes);
    return code;
}

/* Leaves out the files that are no pictures. */
static int list_pictures(cvol_context *context, stack *s, const char *path)
{
    int code = cvol_folder_open(context, &s->files, path);
    size_t kept = 0;
    for (size_t i = 0; i < s->files.count && !code; i++) {
        char *file = s->files.paths[i];
        const kind of = kind_of(file);
        if (of == PNG || of == JPEG) {
            s->files.paths[i] = s->files.paths[kept];
            s->files.paths[kept++] = file;
        } else if (cvol_folder_name_ends(file, ".png") || cvol_folder_name_ends(file, ".jpg") ||
                   cvol_folder_name_ends(file, ".jpeg")) {
            code = cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: is not a PNG or JPEG file, although its name ends like one: the "
                             "volume would lack slices without it",
                             file);
        }
    }
    while (!code && s->files.count > kept)
        free(s->files.paths[--s->files.count]);
    if (!code && !kept) /* files that were removed since the folder was recognised */
        code = cvol_fail(context, CVOL_ERROR_IO, "%s: has no PNG or JPEG file", path);
    return code;
}

static int find_pictures(cvol_context *context, cvol_grid *grid, cvol_stored *stored,
                         const char *path, const cvol_read_options *options)
{
    stack *s = calloc(1, sizeof *s);
    size_t channel;
    if (!s)
        return cvol_fail_memory(context, sizeof *s, path);
    stored->slices = (cvol_slices){.state = s, .read = read_slices, .close = close_stack};
    int code = list_pictures(context, s, path);
    if (!code)
        code = read_picture(context, &s->first, s->files.paths[0]);
    free(s->first.pixels);
    s->first.pixels = NULL;
    if (!code && s->first.channels == 3 && !cvol_labels_set_colours(&stored->labels, 3))
        code = cvol_fail_memory(context, sizeof(cvol_channel_label), path);
    if (!code)
        code = cvol_format_choose(context, &channel, path, "channel", "--channel",
                                  (size_t)s->first.channels, options->has_channel,
                                  options->channel);
    if (code)
        return code;
    s->channel = (int)channel;
    *grid = cvol_grid_make(s->first.width, s->first.height, s->files.count,
                           s->first.bits == 8 ? CVOL_UINT8 : CVOL_UINT16);
    return CVOL_OK;
}

const cvol_format cvol_format_pictures = {
    .name = "folder of pictures",
    .recognise_folder = recognise_folder,
    .find = find_pictures,
    .takes = CVOL_TAKES_SPACING | CVOL_TAKES_CHANNEL,
};
