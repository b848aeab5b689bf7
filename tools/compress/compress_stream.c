/* Compresses volumes that are larger than memory, slab by slab. */
#include "tools/compress/compress_stream.h"

#include <math.h>
#include <sys/resource.h>
#include <unistd.h>

/* Bytes of memory that this process can use; infinity: no limit is known. */
static double usable_memory(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    const double machine = pages > 0 && page > 0 ? (double)pages * (double)page : (double)INFINITY;
    struct rlimit space;
    const double limit = !getrlimit(RLIMIT_AS, &space) && space.rlim_cur != RLIM_INFINITY
                             ? (double)space.rlim_cur
                             : (double)INFINITY;
    return fmin(machine, limit);
}

int open_slab_input(cvol_context *context, slab_input *in, const char *path, common_options *common,
                    int always)
{
    int status = read_type_name(common);
    if (status)
        return status;
    int code = cvol_volume_stream_open(context, &in->stream, path, &common->read);
    if (code)
        return report_context_error(context, code, NULL);
    in->path = path;
    in->common = common;
    const double bytes = (double)cvol_grid_bytes(slab_input_grid(in));
    if (!always && bytes <= usable_memory() / 4) {
        close_slab_input(in);
        return EXIT_DONE;
    }
    if (!common->json) {
        clear_progress();
        fprintf(stderr, "cvol: %s: %.4g MiB of samples, compressed slab by slab\n", path,
                bytes / (1 << 20));
    }
    return EXIT_DONE;
}

void close_slab_input(slab_input *in)
{
    cvol_volume_stream_free(in->stream);
    in->stream = NULL;
}

const cvol_grid *slab_input_grid(const slab_input *in)
{
    return cvol_volume_stream_grid(in->stream);
}

/* Replaces missing values, if the user gave a value for them. */
static int fill_slab(cvol_context *context, const slab_input *in, void *samples, size_t slices,
                     size_t rows)
{
    cvol_volume slab = {*slab_input_grid(in), samples};
    slab.grid.dims[1] = rows;
    slab.grid.dims[2] = slices;
    return in->common->fill_given ? cvol_volume_fill(context, &slab, in->common->fill) : CVOL_OK;
}

static int read_slab(cvol_context *context, void *user, void *samples, size_t first, size_t slices)
{
    const slab_input *in = user;
    const int code = cvol_volume_stream_read(context, in->stream, samples, first, slices);
    return code ? code : fill_slab(context, in, samples, slices, slab_input_grid(in)->dims[1]);
}

static int read_rows(cvol_context *context, void *user, void *samples, size_t first, size_t slices,
                     size_t first_row, size_t rows)
{
    const slab_input *in = user;
    const int code = cvol_volume_stream_read_rows(context, in->stream, samples, first, slices,
                                                  first_row, rows);
    return code ? code : fill_slab(context, in, samples, slices, rows);
}

static cvol_sample_source source_of(slab_input *in)
{
    return (cvol_sample_source){
        .read = read_slab,
        .user = in,
        .read_rows = cvol_volume_stream_can_read_rows(in->stream) ? read_rows : NULL};
}

/* Warns if some samples are of a value far from all others: files that are made slab by slab store
 * it like any other. */
static void warn_about_mark(cvol_context *context, const cvol_array *array, const char *path)
{
    cvol_histogram histogram;
    if (cvol_array_compute_histogram(context, &histogram, array) || !histogram.mark_count)
        return;
    clear_progress();
    fprintf(stderr,
            "cvol: %s: some samples are %g, far from all others, and degrade those; only volumes "
            "that fit into memory can have missing values\n",
            path, histogram.mark);
}

/* Reads one brick of the file for its properties, and takes the rest from the report. */
int read_streamed_info(cvol_context *context, cvol_array_info *info, const char *path,
                       const cvol_grid *grid, const cvol_compress_report *report)
{
    static const size_t zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    const cvol_file_part part = {.size = sizeof(cvol_file_part), .begin = zero, .end = one};
    cvol_array *array;
    int code = cvol_array_read_part(context, &array, NULL, path, &part);
    if (code)
        return report_error(EXIT_FAILED, "%s: was written, but cannot be described: %s", path,
                            cvol_context_message(context));
    cvol_array_get_info(info, array);
    warn_about_mark(context, array, path);
    cvol_array_free(array);
    info->coefficients = report->coefficients;
    info->rho = (double)report->coefficients / (double)cvol_grid_samples(grid);
    return EXIT_DONE;
}

stream_compressor *compressor_of_streams = cvol_compress_stream;

int compress_slabs(cvol_context *context, slab_input *in, const char *out_path,
                   const cvol_compress_options *options, cvol_compress_report *report)
{
    const cvol_sample_source source = source_of(in);
    return compressor_of_streams(context, report, out_path, &source, slab_input_grid(in), options);
}

int add_slabs_to(cvol_context *context, cvol_series_writer *writer, slab_input *in,
                 cvol_compress_report *report, const cvol_compress_options *options)
{
    const cvol_sample_source source = source_of(in);
    return cvol_series_add_stream(context, writer, report, &source, slab_input_grid(in), options);
}
