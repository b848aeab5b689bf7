/* The fourth axis of a NRRD: times or channels.
 *
 * It is the only axis without a direction in space, or the only one whose kind is neither domain
 * nor space; without such facts, the fastest axis if it has at most four places, else the slowest.
 * Its kind tells the meaning: list and time are times, other kinds channels; without a kind, the
 * slowest axis has times. Volumes along the slowest axis lie one after the other. Those along other
 * axes are mixed sample by sample, so the whole file is held in memory. */
#define _GNU_SOURCE
#include "volume/formats/nrrd.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#include "base/context.h"
#include "base/grid.h"
#include "base/memory.h"
#include "volume/io/format.h"
#include "volume/io/interleaved.h"

enum { CHANNELS_WITHOUT_KIND = 4 };

/* ---- the axis ---- */

static int is_spatial(const char *kind)
{
    return !strcasecmp(kind, "domain") || !strcasecmp(kind, "space");
}

/* The only axis that is not marked; -1 if they are none or several. */
static int only_other(const int *marked)
{
    int found = -1;
    for (int a = 0; a < CVOL_NRRD_AXES; a++)
        if (!marked[a]) {
            if (found >= 0)
                return -1;
            found = a;
        }
    return found;
}

int cvol_nrrd_find_stated_extra(const nrrd *n, const int *known)
{
    char kind[32];
    int spatial[CVOL_NRRD_AXES];
    for (size_t a = 0; a < CVOL_NRRD_AXES; a++) {
        cvol_nrrd_get_word(kind, sizeof kind, n->header.value[NRRD_KINDS], a);
        spatial[a] = is_spatial(kind);
    }
    const int extra = only_other(known);
    return extra < 0 ? only_other(spatial) : extra;
}

void cvol_nrrd_find_extra(nrrd *n, const int *known)
{
    static const char ending[] = "-color";
    const size_t most = sizeof ending - 1;
    int extra = cvol_nrrd_find_stated_extra(n, known);
    if (extra < 0)
        extra = n->sizes[0] <= CHANNELS_WITHOUT_KIND ? 0 : CVOL_NRRD_AXES - 1;
    char kind[32];
    cvol_nrrd_get_word(kind, sizeof kind, n->header.value[NRRD_KINDS], (size_t)extra);
    const size_t length = strlen(kind);
    const int has_kind = length && strcmp(kind, "???") && strcasecmp(kind, "none") &&
                         !is_spatial(kind);
    n->extra = (size_t)extra;
    n->extra_size = n->sizes[extra];
    n->has_channels = has_kind ? strcasecmp(kind, "list") && strcasecmp(kind, "time")
                               : extra < CVOL_NRRD_AXES - 1;
    n->has_colours = length > most && !strcasecmp(kind + length - most, ending);
}

/* ---- its volumes ---- */

/* Step and unit of times. */
static void read_times(const nrrd *n, cvol_labels *labels)
{
    char word[32];
    double step;
    cvol_nrrd_get_word(word, sizeof word, n->header.value[NRRD_SPACINGS], n->extra);
    if (!cvol_text_number(word, strlen(word), &step) || !(step > 0) || !isfinite(step))
        return;
    labels->time_step = step;
    cvol_nrrd_get_word(word, sizeof word, n->header.value[NRRD_UNITS], n->extra);
    cvol_labels_set_unit(labels, word, strlen(word));
}

/* Samples of one volume, which are mixed with those of the others. */
static int read_mixed(nrrd *n, cvol_stored *stored, size_t number, size_t samples)
{
    cvol_context *context = n->header.context;
    const char *path = stored->data_path ? stored->data_path : n->header.path;
    cvol_strided strided = {.big_endian = stored->big_endian};
    size_t step = 1, bytes;
    for (size_t a = 0, kept = 0; a < CVOL_NRRD_AXES; step *= n->sizes[a++])
        if (a == n->extra)
            strided.first = number * step;
        else
            strided.stride[kept++] = step;
    if (!cvol_size_multiply(&bytes, samples, cvol_type_size(n->grid.type)) ||
        bytes > context->limit_bytes)
        return cvol_fail(
            context, CVOL_ERROR_LIMIT,
            "%s: %zu volumes, which are mixed sample by sample, are more than the limit "
            "of %llu bytes",
            n->header.path, n->extra_size, (unsigned long long)context->limit_bytes);
    return stored->encoding == CVOL_ENCODING_GZIP
               ? cvol_strided_inflate(context, stored, &strided, &n->grid, path, stored->offset,
                                      stored->byte_skip, samples)
               : cvol_strided_read(context, stored, &strided, &n->grid, path,
                                   stored->offset + stored->byte_skip, samples);
}

int cvol_nrrd_choose(nrrd *n, cvol_stored *stored, const cvol_read_options *options)
{
    cvol_context *context = n->header.context;
    size_t index, channel, samples;
    int code = cvol_format_choose(context, &channel, n->header.path, "channel", "--channel",
                                  n->has_channels ? n->extra_size : 1, options->has_channel,
                                  options->channel);
    if (!code)
        code = cvol_format_choose(context, &index, n->header.path, "volume", "--time",
                                  n->has_channels ? 1 : n->extra_size, options->has_index,
                                  options->index);
    if (code || n->extra_size == 1)
        return code;
    if (n->has_colours && !cvol_labels_set_colours(&stored->labels, n->extra_size))
        return cvol_fail_memory(context, n->extra_size * sizeof(cvol_channel_label),
                                n->header.path);
    if (!n->has_channels)
        read_times(n, &stored->labels);
    if (stored->encoding == CVOL_ENCODING_TEXT || stored->at_end || stored->line_skip)
        return cvol_text_header_unsupported(
            &n->header, NRRD_SIZES,
            "have a fourth axis, which is read only from raw and gzip samples right behind the "
            "header, or with 'byte skip'");
    code = cvol_grid_check_within(context, &n->grid, n->header.path, UINT64_MAX);
    if (code)
        return code;
    if (!cvol_size_multiply(&samples, cvol_grid_samples(&n->grid), n->extra_size) ||
        samples > SIZE_MAX / 16)
        return cvol_fail(context, CVOL_ERROR_LIMIT, "%s: has too many samples", n->header.path);
    const size_t number = n->has_channels ? channel : index;
    if (n->extra < CVOL_NRRD_AXES - 1)
        return read_mixed(n, stored, number, samples);
    if (__builtin_add_overflow(stored->byte_skip, number * (uint64_t)cvol_grid_bytes(&n->grid),
                               &stored->byte_skip))
        return cvol_fail(context, CVOL_ERROR_LIMIT, "%s: has too many samples", n->header.path);
    stored->may_go_on = stored->has_more_volumes = 1;
    return CVOL_OK;
}
