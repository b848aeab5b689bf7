/* Samples in files: raw in either byte order, deflated, or as text. */
#ifndef CVOL_VOLUME_IO_STORED_H
#define CVOL_VOLUME_IO_STORED_H

#include "base/bytes.h"
#include "cvol/series.h"
#include "volume/io/input.h"
#include "volume/io/wide.h"

typedef enum cvol_encoding {
    CVOL_ENCODING_RAW,
    CVOL_ENCODING_GZIP, /* reading: or zlib */
    CVOL_ENCODING_ZLIB,
    CVOL_ENCODING_TEXT /* decimal numbers separated by blanks, line ends or commas; reading only */
} cvol_encoding;

/* A channel's name and colour; name "": the file has none. */
typedef struct cvol_channel_label {
    char name[64]; /* UTF-8, only printable characters */
    int has_colour;
    double colour[3];
} cvol_channel_label;

/* A file's description of its volumes. */
typedef struct cvol_labels {
    double time_step;   /* positive and finite; 0: unknown */
    char time_unit[16]; /* "s", "ms", ..., or "" */
    size_t channels;    /* with a label */
    cvol_channel_label *channel;
    int are_colours; /* channels 0, 1 and 2 are red, green and blue of one colour; a fourth is alpha
                      */
} cvol_labels;

/* Labels the channels as components of colours: names, colours, `are_colours`. Does nothing unless
 * there are three or four. 1, or 0 without memory. */
int cvol_labels_set_colours(cvol_labels *labels, size_t channels);

/* Sets a channel's name to the file's text of `size` bytes; "" if bytes are not UTF-8 or not
 * printable. A long name is cut between characters. */
void cvol_labels_set_name(cvol_channel_label *channel, const char *text, size_t size);
/* Appends the names of channels to the context's message, which requests one. Returns `code`. */
int cvol_labels_append_names(cvol_context *context, const cvol_labels *labels, int code);
/* A unit of time by one of its names; "" if it is none. */
void cvol_labels_set_unit(cvol_labels *labels, const char *text, size_t size);
/* Makes the unit of a grid printable UTF-8: removes a character that was cut at the end of the
 * field, and takes other texts that are not UTF-8 as Latin-1, in which old files have µ and Å. */
void cvol_labels_repair_unit(char unit[16]);

/* Slices that a format's reader provides itself, from many files or by a library. */
typedef struct cvol_slices {
    void *state;
    /* Reads slices first .. first + count - 1 into `out`, in the machine's byte order. NULL:
     * cvol_stored describes the samples. */
    int (*read)(cvol_context *context, void *state, void *out, size_t first, size_t count);
    /* The same for rows first_row .. first_row + rows - 1 of these slices; NULL: only whole slices
     * can be read. */
    int (*read_rows)(cvol_context *context, void *state, void *out, size_t first, size_t count,
                     size_t first_row, size_t rows);
    void (*close)(void *state);
} cvol_slices;

/* The place and encoding of a header's samples, found by a format's reader. */
typedef struct cvol_stored {
    char *data_path; /* the file that holds them, freed with free(); NULL: the header's own */
    cvol_encoding encoding;
    int big_endian;
    cvol_wide wide;       /* not NONE: the samples are made of these, and the grid's type is
                             CVOL_WIDE_TYPE until then; as text only integers */
    uint64_t offset;      /* of the first stored byte in the file */
    uint64_t line_skip;   /* lines between `offset` and the stored bytes */
    uint64_t byte_skip;   /* bytes before the samples, counted after inflating */
    uint64_t stored_size; /* of compressed samples, or of text; 0: to the file's end */
    int at_end;           /* raw samples are the last bytes of the file */
    int may_go_on;   /* other bytes may follow raw samples: for example in a detached file with more
                        volumes */
    int has_remarks; /* bytes of other kinds follow the last volume's compressed samples */
    int has_more_volumes; /* other volumes follow: the end of compressed samples is not that of the
                             stream */
    int undescribed;      /* the grid is the caller's, for a file of samples only */
    cvol_labels labels;   /* the reader's caller frees the list */
    cvol_slices slices;   /* the reader's caller closes it */
} cvol_stored;

/* Reads samples stored as text, or elements that are wide integers: `size` bytes from `offset`, 0:
 * to the file's end. More samples than the grid's are an error unless may_go_on. */
int cvol_stored_read_text(cvol_context *context, cvol_volume **out, const cvol_grid *grid,
                          cvol_wide wide, const cvol_input *input, uint64_t offset, uint64_t size,
                          int may_go_on);

/* A writer's plan of a file for a grid: all except the samples. */
typedef struct cvol_write_plan {
    cvol_bytes header;
    int big_endian;         /* of the samples */
    int widens;             /* samples of uint8 are written as uint16, low byte first */
    cvol_encoding encoding; /* of the samples; attached or detached */
    int packs_header;       /* the compressed stream begins with the header */
    char *data_path;        /* a separate file of the raw samples; NULL: they follow the header */
    size_t size_at; /* place of CVOL_PLAN_SIZE_BYTES blanks in the header for the decimal size of
                       the compressed samples; 0: nowhere */
    cvol_bytes trailer;                /* bytes that follow raw samples in their file */
    const cvol_series_options *series; /* set before planning: the volumes that follow each other,
                                          and their labels */
} cvol_write_plan;

#define CVOL_PLAN_SIZE_BYTES 20

/* A format's own way of writing, for formats that are more than a header and samples. */
typedef struct cvol_write_sink {
    void *state;
    /* Writes the next bytes of the volumes: whole samples. NULL: a plan describes the file. */
    int (*write)(cvol_context *context, void *state, const void *data, size_t size);
    /* Samples of a value have none, from now on; NULL: that makes no difference. */
    int (*add_missing)(cvol_context *context, void *state, double value);
    /* Gives the complete file its name. */
    int (*commit)(cvol_context *context, void *state);
    /* Frees the state, and removes what has no name yet. */
    void (*close)(void *state);
} cvol_write_sink;

void cvol_write_plan_free(cvol_write_plan *plan);
/* Sets data_path: the header's path with another ending. A name that cannot be written in a
 * header's line is an ARGUMENT error. */
int cvol_write_plan_detach(cvol_context *context, cvol_write_plan *plan, const char *header_path,
                           const char *ending);
/* Text headers: samples of `encoding` follow the header, and *data_name is NULL. If the header's
 * path has the ending `detached`, raw samples go to a separate file with the ending .raw;
 * *data_name is its name without the folder. */
int cvol_write_plan_text(cvol_context *context, cvol_write_plan *plan, const char *header_path,
                         const char *detached, cvol_encoding encoding, const char **data_name);

#endif
