/* Samples as files store them: raw in either byte order, deflated, or as text. */
#ifndef CVOL_VOLUME_STORED_H
#define CVOL_VOLUME_STORED_H

#include "cvol/volume.h"

struct cvol_bytes;

typedef enum cvol_encoding {
    CVOL_ENCODING_RAW,
    CVOL_ENCODING_GZIP, /* reading: or zlib */
    CVOL_ENCODING_ZLIB,
    CVOL_ENCODING_TEXT /* decimal numbers between blanks, line ends or commas; reading only */
} cvol_encoding;

/* Where the samples of a header are. */
typedef struct cvol_stored {
    const char *path; /* the file that holds them */
    cvol_encoding encoding;
    int big_endian;
    uint64_t offset;      /* of the first stored byte in the file */
    uint64_t line_skip;   /* lines between `offset` and the stored bytes */
    uint64_t byte_skip;   /* bytes before the samples, counted after inflating */
    uint64_t stored_size; /* of compressed samples; 0: all bytes to the file's end */
    int at_end;           /* raw samples are the last bytes of the file */
    int may_go_on;        /* other bytes may follow raw samples: a detached file is cut from */
} cvol_stored;

/* Reads the samples of `grid`, which is checked first. `name` is the header's file. Nothing is
 * allocated that the file's size does not make plausible. */
int cvol_stored_read(cvol_context *context, cvol_volume **out, const cvol_grid *grid,
                     const char *name, const cvol_stored *stored);

/* Takes what a writer makes, piece by piece. */
typedef int (*cvol_sink_fn)(cvol_context *context, void *sink, const void *data, size_t size);

/* Sends `prefix` and the samples (little-endian) to the sink, as one stream. */
int cvol_stored_write(cvol_context *context, const cvol_volume *volume, cvol_encoding encoding,
                      const void *prefix, size_t prefix_size, cvol_sink_fn put, void *sink);
/* The sinks: a cvol_output, a cvol_bytes. */
int cvol_sink_output(cvol_context *context, void *output, const void *data, size_t size);
int cvol_sink_bytes(cvol_context *context, void *bytes, const void *data, size_t size);

/* A whole file: `header`, then the samples in this encoding. */
int cvol_stored_write_file(cvol_context *context, const cvol_volume *volume, const char *path,
                           const void *header, size_t header_size, cvol_encoding encoding);

/* A detached header's data file: the header's path with another ending; the caller frees it. A
 * name that would not survive in a header's line is an ARGUMENT error. */
int cvol_stored_data_path(cvol_context *context, char **out, const char *header_path,
                          const char *ending);
/* Raw samples in their own file, then the header, so that no header is without its samples. */
int cvol_stored_write_detached(cvol_context *context, const cvol_volume *volume, const char *path,
                               const struct cvol_bytes *header, const char *data_path);

/* 1 where the machine's own order is big-endian. */
int cvol_machine_is_big_endian(void);
/* Reverses the bytes of each of `count` elements of `size` bytes (1, 2, 4, 8). */
void cvol_swap_bytes(void *data, size_t count, size_t size);

#endif
