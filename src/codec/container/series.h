/* Files of many volumes: section LIST gives the volumes and their places, and each section VOLM is
 * a file of one volume, from its signature to its end. */
#ifndef CVOL_CODEC_CONTAINER_SERIES_H
#define CVOL_CODEC_CONTAINER_SERIES_H

#include "base/bytes.h"
#include "base/file.h"
#include "cvol/series.h"

typedef struct cvol_channel {
    double colour[3];
    char name[CVOL_CHANNEL_NAME_BYTES];
} cvol_channel;

/* The place of a volume: the content of its section. */
typedef struct cvol_extent {
    uint64_t offset, length;
} cvol_extent;

struct cvol_series {
    int times, channels, is_list, are_colours;
    char unit[CVOL_TIME_UNIT_BYTES];
    cvol_channel *channel;
    double *time;
    cvol_extent *volumes; /* channel + channels time */
};

/* Makes a series with room for this many volumes, all zero. Errors: MEMORY. */
int cvol_series_make(cvol_context *context, cvol_series **out, int times, int channels);

/* The size of the section's content, which depends on the counts only. */
uint64_t cvol_series_list_bytes(const cvol_series *series);
void cvol_series_put(cvol_bytes *out, const cvol_series *series);

/* Reads the series of a file in memory, which may be cut. The caller frees *out. Errors: as
 * cvol_series_read, except IO. */
int cvol_series_take(cvol_context *context, cvol_series **out, const uint8_t *data, size_t size,
                     const char *name);
/* Does the same with the content of LIST. */
int cvol_series_take_list(cvol_context *context, cvol_series **out, cvol_cursor *content,
                          const char *name);

/* A volume within its file, and its name in messages: "run.cvol, time 2, channel 0 (from byte
 * 512)". */
typedef struct cvol_series_place {
    const uint8_t *data;
    size_t size; /* less than the volume's length if the file ends early */
    char name[512];
} cvol_series_place;

/* Errors: ARGUMENT (no such time or channel), CORRUPT (no volume lies there, or the file ends
 * before it), FORMAT (not a file of one volume). */
int cvol_series_find(cvol_context *context, cvol_series_place *out, const cvol_series *series,
                     int time, int channel, const uint8_t *data, size_t size, const char *name);

/* Adds a volume that `write` writes to the output, from the output's current position. Errors: the
 * errors of cvol_series_add and of `write`. */
typedef int cvol_series_write(cvol_context *context, cvol_output *output, void *user);
int cvol_series_add_written(cvol_context *context, cvol_series_writer *writer,
                            const cvol_grid *grid, cvol_series_write *write, void *user);

/* Tests if the file's sections match the list, and if every volume decodes and has the first one's
 * shape and type. The caller has verified every checksum of the file. Errors: as
 * cvol_container_try. */
int cvol_series_try(cvol_context *context, const uint8_t *data, size_t size, const char *name);

#endif
