/* DICOM (dicomstandard.org): a series of files in a folder, or a file of many frames, is a volume
 * in millimetres, x to the patient's left, y to the back, z up.
 *
 * A folder is read, or any file of the series in it. head.c reads headers, series.c finds the
 * slices and their positions, frame.c reads their samples. Rescale slope and intercept become the
 * grid's; if slices have their own, as in positron emission tomography, samples become floats. */
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "volume/formats/dicom/frame.h"
#include "volume/formats/dicom/series.h"
#include "volume/io/format.h"

typedef struct dicom {
    cvol_dicom_series series;
    size_t width, height, sample;
    cvol_type stored;
    void *frame; /* one slice, if samples become floats */
} dicom;

static void close_dicom(void *state)
{
    dicom *d = state;
    if (!d)
        return;
    cvol_dicom_series_close(&d->series);
    free(d->frame);
    free(d);
}

static double value_at(const void *data, cvol_type type, size_t i)
{
    switch (type) {
    case CVOL_UINT8:
        return ((const uint8_t *)data)[i];
    case CVOL_INT8:
        return ((const int8_t *)data)[i];
    case CVOL_UINT16:
        return ((const uint16_t *)data)[i];
    case CVOL_INT16:
        return ((const int16_t *)data)[i];
    case CVOL_UINT32:
        return ((const uint32_t *)data)[i];
    default:
        return ((const int32_t *)data)[i];
    }
}

static int read_slice(cvol_context *context, dicom *d, const cvol_dicom_slice *slice, void *out)
{
    const cvol_dicom_head *head = &d->series.heads[slice->head];
    if (!d->series.varies)
        return cvol_dicom_frame_read(context, head, slice->frame, d->sample, out);
    const size_t pixels = d->width * d->height;
    if (!d->frame && !(d->frame = cvol_allocate(pixels, cvol_type_size(d->stored))))
        return cvol_fail_memory(context, pixels, head->path);
    int code = cvol_dicom_frame_read(context, head, slice->frame, d->sample, d->frame);
    const cvol_dicom_frame *frame = &head->frame[slice->frame];
    for (size_t i = 0; !code && i < pixels; i++)
        ((float *)out)[i] = (float)(value_at(d->frame, d->stored, i) * frame->slope +
                                    frame->intercept);
    return code;
}

static int read_slices(cvol_context *context, void *state, void *out, size_t first, size_t count)
{
    dicom *d = state;
    const cvol_type type = d->series.varies ? CVOL_FLOAT32 : d->stored;
    const size_t bytes = d->width * d->height * cvol_type_size(type);
    int code = CVOL_OK;
    for (size_t z = 0; !code && z < count; z++)
        code = read_slice(context, d, &d->series.slices[first + z], (uint8_t *)out + z * bytes);
    return code;
}

static int find_dicom(cvol_context *context, cvol_grid *grid, cvol_stored *stored, const char *path,
                      const cvol_read_options *options)
{
    size_t first;
    dicom *d = calloc(1, sizeof *d);
    if (!d)
        return cvol_fail_memory(context, sizeof *d, path);
    stored->slices = (cvol_slices){.state = d, .read = read_slices, .close = close_dicom};
    cvol_dicom_series *series = &d->series;
    int code = cvol_dicom_series_list(context, series, path, &first);
    if (!code)
        code = cvol_dicom_series_choose(context, series, path, first, options);
    for (size_t z = 0, last = SIZE_MAX; !code && z < series->count; z++)
        if (series->slices[z].head != last) {
            last = series->slices[z].head;
            code = cvol_dicom_frame_check(context, &series->heads[last], &d->stored);
        }
    if (code)
        return code;
    const cvol_dicom_head *head = &series->heads[series->slices[0].head];
    d->width = head->columns;
    d->height = head->rows;
    code = cvol_format_choose(context, &d->sample, path, "channel", "--channel", head->samples,
                              options->has_channel, options->channel);
    *grid = cvol_grid_make(d->width, d->height, series->count, d->stored);
    return code ? code : cvol_dicom_series_place(context, series, grid, path, options);
}

const cvol_format cvol_format_dicom = {
    .name = "DICOM",
    .endings = {".dcm"},
    .recognise = cvol_dicom_recognise,
    .find = find_dicom,
    .takes = CVOL_TAKES_SPACING | CVOL_TAKES_CHANNEL | CVOL_TAKES_INDEX | CVOL_TAKES_SERIES,
    .takes_folder = 1,
};
