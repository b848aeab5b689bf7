/* The values of a volume of several times: all times are drawn with one transfer function and one
 * range of grey levels, as in `cvol render --over-time`. */
#include <stdlib.h>

#include "viewer/volumes/volume_read.h"

enum {
    FITTED = 8,  /* times to fit values to, at most */
    COARSEST = 3 /* level of a part; a file stores the histogram of all samples next to it */
};

static int read_histogram(cvol_context *context, cvol_histogram *out, const shown_volume *v,
                          int time, const viewer_options *options)
{
    cvol_read_options read = v->read;
    cvol_array *array = NULL;
    cvol_volume *samples = NULL;
    cvol_file_report report;
    int code;
    read.index += time;
    const cvol_file_part part = {.size = sizeof part,
                                 .time = read.index,
                                 .channel = read.has_channel ? read.channel : 0,
                                 .level = COARSEST,
                                 .cut = 1};
    if (cvol_file_is_cvol(v->path)) {
        code = cvol_array_read_part(context, &array, &report, v->path, &part);
        if (!code)
            code = cvol_array_compute_histogram(context, out, array);
    } else {
        code = cvol_volume_read(context, &samples, v->path, &read);
        if (!code && options->has_fill)
            code = cvol_volume_fill(context, samples, options->fill);
        if (!code)
            code = cvol_volume_compute_histogram(context, out, samples);
    }
    cvol_array_free(array);
    cvol_volume_free(samples);
    return code;
}

int volume_fit_values(cvol_context *context, shown_volume *v, const viewer_options *options)
{
    const int count = v->times < FITTED ? v->times : FITTED;
    cvol_histogram *each = calloc((size_t)count, sizeof *each);
    if (!each)
        return CVOL_ERROR_MEMORY;
    size_t fitted = 1;
    int code = CVOL_OK;
    each[0] = v->histogram;
    for (int k = 1; k < count && code != CVOL_ERROR_CANCELLED; k++) {
        const int time = (int)((double)k * (v->times - 1) / (count - 1));
        code = read_histogram(context, &each[fitted], v, time, options);
        fitted += !code; /* a damaged time is reported when it is shown */
    }
    cvol_histogram_join(&v->histogram, each, fitted);
    free(each);
    return code == CVOL_ERROR_CANCELLED ? code : CVOL_OK;
}
