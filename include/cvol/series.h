/* cvol/series.h - series: files of several volumes, by time and channel.
 *
 * A series holds times x channels volumes of the same shape, type and position. Each is a complete
 * .cvol file inside the file, so the cost of reading one does not depend on their number.
 * cvol_file_part (cvol/codec.h) chooses the volume for cvol_array_read_part. Functions without that
 * choice, such as cvol_array_read, read time 0, channel 0. */
#ifndef CVOL_SERIES_H
#define CVOL_SERIES_H

#include "cvol/codec.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Limits. */
enum {
    CVOL_SERIES_MOST = 1048576,   /* volumes in a file */
    CVOL_CHANNEL_NAME_BYTES = 64, /* bytes of a name, with the terminating zero */
    CVOL_TIME_UNIT_BYTES = 16     /* bytes of a unit, with the terminating zero */
};

/* The list of volumes of a file. */
typedef struct cvol_series cvol_series;

/* Reads the list of a .cvol file, and none of its volumes; a file of one volume has one time and
 * one channel. The caller frees *out. It succeeds for a file that ends early if the list is
 * complete. Errors: IO, FORMAT, CORRUPT, UNSUPPORTED, LIMIT, MEMORY. */
CVOL_API int cvol_series_read(cvol_context *context, cvol_series **out, const char *path);
/* Frees it; NULL is allowed. */
CVOL_API void cvol_series_free(cvol_series *series);

/* The number of times and of channels, at least 1. */
CVOL_API int cvol_series_times(const cvol_series *series);
CVOL_API int cvol_series_channels(const cvol_series *series);
/* 1 if the file is a series, even one with a single volume; 0 if it is a plain .cvol file. */
CVOL_API int cvol_series_is_list(const cvol_series *series);
/* The value of a time, 0 <= time < times, and the unit: "s", or "" for plain numbers. */
CVOL_API double cvol_series_time(const cvol_series *series, int time);
CVOL_API const char *cvol_series_time_unit(const cvol_series *series);
/* The name of a channel, 0 <= channel < channels; "": none. */
CVOL_API const char *cvol_series_channel_name(const cvol_series *series, int channel);
/* Sets rgb to the colour of a channel in additive pictures: red, green and blue, each 0 to 1. */
CVOL_API void cvol_series_get_channel_colour(double rgb[3], const cvol_series *series, int channel);
/* 1 if channels 0, 1 and 2 are red, green and blue of one colour, and channel 3, if there is one,
 * its alpha; pictures then use one window for all. 0: each channel is a separate volume. */
CVOL_API int cvol_series_has_colours(const cvol_series *series);
/* The bytes of a volume, and its offset in the file. */
CVOL_API uint64_t cvol_series_volume_bytes(const cvol_series *series, int time, int channel);
CVOL_API uint64_t cvol_series_volume_offset(const cvol_series *series, int time, int channel);

/* Copies one volume of a series to its own file, unchanged. file_bytes may be NULL. Errors:
 * ARGUMENT (no such time or channel), those of cvol_series_read. */
CVOL_API int cvol_series_extract(cvol_context *context, const char *path, int time, int channel,
                                 const char *out_path, uint64_t *file_bytes);

/* Sets rgb to the default colour of one of `channels` channels: for one channel white; for two
 * green and magenta; for more blue, green, red, yellow, magenta, cyan, white, and so on. */
CVOL_API void cvol_series_get_default_colour(double rgb[3], int channel, int channels);

/* ---- writing ---- */

/* Options of a series; start with cvol_series_options_defaults(). */
typedef struct cvol_series_options {
    size_t size;                      /* sizeof(cvol_series_options) */
    int times, channels;              /* at least 1; their product at most CVOL_SERIES_MOST */
    const double *time_values;        /* finite, [times]; NULL: 0, 1, 2, ... */
    const char *time_unit;            /* at most 15 bytes; NULL: "" */
    const char *const *channel_names; /* UTF-8, at most 63 bytes each; NULL, or a NULL name: "" */
    const double *channel_colours;    /* [3 channels], each 0 to 1; NULL: default colours */
    int colours;                      /* see cvol_series_has_colours; of 3 or 4 channels */
    int zarr_format; /* of NAME.zarr: 2 (OME-Zarr 0.4; 0 means this), or 3 (OME-Zarr 0.5) */
    const cvol_label *labels; /* of samples that are labels: their names and colours, which
                               * cvol_volume_writer_open_series writes to OME-Zarr; rgb[0] -1: no
                               * colour, name "": no name. NULL: none are known */
    size_t label_count;
} cvol_series_options;

/* Sets *options, which has `size` bytes, to the defaults. */
CVOL_API void cvol_series_options_set_defaults(cvol_series_options *options, size_t size);
/* One time, one channel. */
static inline cvol_series_options cvol_series_options_defaults(void)
{
    cvol_series_options options;
    cvol_series_options_set_defaults(&options, sizeof options);
    return options;
}

/* A series that is being written. */
typedef struct cvol_series_writer cvol_series_writer;

/* Opens a file for times x channels volumes. They are added in order: all channels of time 0, then
 * of time 1, and so on. The file gets its name at commit. The caller ends it with commit or
 * abandon. Errors: ARGUMENT, IO (also a pipe: the list at the start is written last), MEMORY. */
CVOL_API int cvol_series_writer_open(cvol_context *context, cvol_series_writer **out,
                                     const char *path, const cvol_series_options *options);
/* Adds the next volume, with the bytes of cvol_array_write. All volumes must have the dims, type,
 * space, spacing, origin and directions of the first, up to a millionth. file_bytes: of this
 * volume; may be NULL. After an error other than ARGUMENT only abandon may follow. Errors: ARGUMENT
 * (the message names the difference, or all volumes were added), those of cvol_array_write. */
CVOL_API int cvol_series_add(cvol_context *context, cvol_series_writer *writer,
                             const cvol_array *array, uint64_t *file_bytes);
/* Adds the next volume, with the bytes of cvol_compress_stream. Errors: ARGUMENT as above, those of
 * cvol_compress_stream. */
CVOL_API int cvol_series_add_stream(cvol_context *context, cvol_series_writer *writer,
                                    cvol_compress_report *report, const cvol_sample_source *source,
                                    const cvol_grid *grid, const cvol_compress_options *options);
/* Gives the complete file its name and frees the writer, after a failure too; then a file that had
 * the name stays. file_bytes may be NULL. Errors: IO, ARGUMENT (volumes are missing), MEMORY. */
CVOL_API int cvol_series_writer_commit(cvol_context *context, cvol_series_writer *writer,
                                       uint64_t *file_bytes);
/* Removes the unfinished file and frees the writer; NULL is allowed. */
CVOL_API void cvol_series_writer_abandon(cvol_series_writer *writer);

/* ---- in other formats ---- */

/* Opens a file of dense samples for all volumes of a series; `grid` is that of each. Slices are
 * written volume after volume: all channels of time 0, then of time 1, and so on. Only OME-Zarr
 * (NAME.zarr) and OME-TIFF (NAME.ome.tif) hold more than one. labels 1: the samples are labels, and
 * coarser levels of the file hold samples of the volume instead of means; OME-Zarr gets the mark
 * image-label, with the names and colours of series->labels. What `series` points to
 * must outlive the writer; NULL: one volume. Ended like cvol_volume_writer_open. Errors: those of
 * it, ARGUMENT (counts), UNSUPPORTED (several volumes in another format). */
CVOL_API int cvol_volume_writer_open_series(cvol_context *context, cvol_volume_writer **out,
                                            const char *path, const cvol_grid *grid,
                                            const cvol_series_options *series, int labels);
/* The length of FILE in FILE.h5:/NAME, a dataset that writers of volumes write; of another path the
 * whole length. */
CVOL_API size_t cvol_volume_writer_file_length(const char *path);

#ifdef __cplusplus
}
#endif
#endif
