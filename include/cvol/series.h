/* cvol/series.h - files of many volumes: times and channels.
 *
 * A series holds times x channels volumes of the same shape, type and place, each of them a whole
 * .cvol file within the file, to the byte: what it takes to read one does not depend on how many
 * there are. cvol_file_part (cvol/codec.h) says which one cvol_array_read_part reads; what knows
 * nothing of series, as cvol_array_read does, reads time 0, channel 0.
 */
#ifndef CVOL_SERIES_H
#define CVOL_SERIES_H

#include "cvol/codec.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Limits. */
enum {
    CVOL_SERIES_MOST = 1048576,   /* volumes in a file */
    CVOL_CHANNEL_NAME_BYTES = 64, /* of a name, with the zero at its end */
    CVOL_TIME_UNIT_BYTES = 16     /* of a unit, likewise */
};

/* What is in a file. */
typedef struct cvol_series cvol_series;

/* Reads what a .cvol file holds, and none of it: a file of one volume has one time and one channel.
 * The caller frees *out. Of a file that ends early this succeeds if its list is there.
 * Errors: IO, FORMAT, CORRUPT, UNSUPPORTED, LIMIT, MEMORY. */
CVOL_API int cvol_series_read(cvol_context *context, cvol_series **out, const char *path);
/* Frees it; NULL is allowed. */
CVOL_API void cvol_series_free(cvol_series *series);

/* How many there are, at least 1. */
CVOL_API int cvol_series_times(const cvol_series *series);
CVOL_API int cvol_series_channels(const cvol_series *series);
/* 1 if the file is one of many volumes, even if there is but one; 0: of one. */
CVOL_API int cvol_series_is_list(const cvol_series *series);
/* The value of a time, 0 <= time < times, in the unit ("s", or "" where they are mere numbers). */
CVOL_API double cvol_series_time(const cvol_series *series, int time);
CVOL_API const char *cvol_series_time_unit(const cvol_series *series);
/* A channel's name, "" if it has none, and its colour for additive pictures: red, green and blue,
 * each 0 to 1. 0 <= channel < channels. */
CVOL_API const char *cvol_series_channel_name(const cvol_series *series, int channel);
CVOL_API void cvol_series_channel_colour(const cvol_series *series, int channel, double rgb[3]);
/* 1 if channels 0, 1 and 2 are red, green and blue of one colour, and channel 3, if there is one,
 * its alpha. Pictures then have one window for all. 0: channels are volumes of their own. */
CVOL_API int cvol_series_colours(const cvol_series *series);
/* A volume's bytes, and where they begin in the file. */
CVOL_API uint64_t cvol_series_volume_bytes(const cvol_series *series, int time, int channel);
CVOL_API uint64_t cvol_series_volume_offset(const cvol_series *series, int time, int channel);

/* Writes one volume of a file as a file of its own, the bytes as they are. file_bytes may be NULL.
 * Errors: ARGUMENT (no such time or channel), those of cvol_series_read. */
CVOL_API int cvol_series_extract(cvol_context *context, const char *path, int time, int channel,
                                 const char *out_path, uint64_t *file_bytes);

/* The colour that channel i of so many has unless it is given one: of one white, of two green and
 * magenta, of more blue, green, red, yellow, magenta, cyan, white and so on. */
CVOL_API void cvol_series_default_colour(double rgb[3], int channel, int channels);

/* ---- writing ---- */

/* What is known before the first volume. */
typedef struct cvol_series_options {
    int times, channels;              /* at least 1; their product at most CVOL_SERIES_MOST */
    const double *time_values;        /* finite, [times]; NULL: 0, 1, 2, ... */
    const char *time_unit;            /* at most 15 bytes; NULL: "" */
    const char *const *channel_names; /* UTF-8, at most 63 bytes each; NULL, or one is NULL: "" */
    const double *channel_colours;    /* [3 channels], each 0 to 1; NULL: the default ones */
    int colours;                      /* see cvol_series_colours; of 3 or 4 channels */
} cvol_series_options;

/* One time, one channel. */
CVOL_API cvol_series_options cvol_series_options_defaults(void);

/* A file of many volumes that is being written. */
typedef struct cvol_series_writer cvol_series_writer;

/* Opens a file for times x channels volumes, which are then added one after the other: all channels
 * of time 0, those of time 1, and so on. It appears under its name when it is committed; the caller
 * ends it with one of commit and abandon. Errors: ARGUMENT, IO (a pipe too: the list in front is
 * known last), MEMORY. */
CVOL_API int cvol_series_writer_open(cvol_context *context, cvol_series_writer **out,
                                     const char *path, const cvol_series_options *options);
/* The next volume: what cvol_array_write would write. All volumes must have the first one's dims,
 * type, space, spacing, origin and directions, these to a millionth. file_bytes: of this volume;
 * may be NULL. After an error that is not ARGUMENT the writer can only be abandoned. Errors:
 * ARGUMENT (the sentence says what differs, or that all volumes are there), those of
 * cvol_array_write. */
CVOL_API int cvol_series_add(cvol_context *context, cvol_series_writer *writer,
                             const cvol_array *array, uint64_t *file_bytes);
/* The next volume: what cvol_compress_stream would write. Errors: ARGUMENT as above, those of
 * cvol_compress_stream. */
CVOL_API int cvol_series_add_stream(cvol_context *context, cvol_series_writer *writer,
                                    cvol_compress_report *report, const cvol_sample_source *source,
                                    const cvol_grid *grid, const cvol_compress_options *options);
/* Gives the file its name and frees the writer, also when it fails: then nothing was replaced.
 * file_bytes may be NULL. Errors: IO, ARGUMENT (volumes are missing), MEMORY. */
CVOL_API int cvol_series_writer_commit(cvol_context *context, cvol_series_writer *writer,
                                       uint64_t *file_bytes);
/* Leaves nothing behind and frees the writer; NULL is allowed. */
CVOL_API void cvol_series_writer_abandon(cvol_series_writer *writer);

#ifdef __cplusplus
}
#endif
#endif
