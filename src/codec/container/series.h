/* Files of many volumes: section LIST says what there is and where, and each section VOLM is a
 * file of one volume, from its signature to its end.
 */
#ifndef CVOL_CODEC_CONTAINER_SERIES_H
#define CVOL_CODEC_CONTAINER_SERIES_H

#include "base/bytes.h"
#include "base/file.h"
#include "cvol/series.h"

typedef struct cvol_channel {
    double colour[3];
    char name[CVOL_CHANNEL_NAME_BYTES];
} cvol_channel;

/* Where a volume lies: the content of its section. */
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

/* One with room for so many, all zero. Errors: MEMORY. */
int cvol_series_make(cvol_context *context, cvol_series **out, int times, int channels);

/* The section's content: of so many bytes, whatever is in it. */
uint64_t cvol_series_list_bytes(const cvol_series *series);
void cvol_series_put(cvol_bytes *out, const cvol_series *series);

/* Of a file in memory, which may be cut. The caller frees *out. Errors: those of cvol_series_read
 * but IO. */
int cvol_series_take(cvol_context *context, cvol_series **out, const uint8_t *data, size_t size,
                     const char *name);
/* The same of LIST's content. */
int cvol_series_take_list(cvol_context *context, cvol_series **out, cvol_cursor *content,
                          const char *name);

/* A volume within its file, and what messages call it: "run.cvol, time 2, channel 0 (from byte
 * 512)". */
typedef struct cvol_series_place {
    const uint8_t *data;
    size_t size; /* less than its length where the file ends early */
    char name[512];
} cvol_series_place;

/* Errors: ARGUMENT (no such time or channel), CORRUPT (no volume lies there, or the file ends
 * before it), FORMAT (it is no file of one volume). */
int cvol_series_find(cvol_context *context, cvol_series_place *out, const cvol_series *series,
                     int time, int channel, const uint8_t *data, size_t size, const char *name);

/* Adds a volume that `write` writes to the output, from where the output is. Errors: those of
 * cvol_series_add and of `write`. */
typedef int cvol_series_write(cvol_context *context, cvol_output *output, void *user);
int cvol_series_add_written(cvol_context *context, cvol_series_writer *writer,
                            const cvol_grid *grid, cvol_series_write *write, void *user);

/* Whether what the list says is what follows it, and every volume decodes and has the first one's
 * shape and type; every checksum of the file was found to hold. Errors: those of
 * cvol_container_try. */
int cvol_series_try(cvol_context *context, const uint8_t *data, size_t size, const char *name);

#endif
