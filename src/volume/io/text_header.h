/* Text headers of named fields, one "name: value" or "name = value" per line, before samples that
 * follow or that are in a separate file: the common part of NRRD and MetaImage. */
#ifndef CVOL_VOLUME_IO_TEXT_HEADER_H
#define CVOL_VOLUME_IO_TEXT_HEADER_H

#include "volume/io/stored.h"
#include "volume/io/text.h"

#define CVOL_COUNT(array) (sizeof(array) / sizeof(array)[0])

/* One word of a format and its meaning. */
typedef struct cvol_keyword {
    const char *word;
    int value;
} cvol_keyword;

/* 1 and the word's value if it is in the table; letters match in either case. */
int cvol_keyword_find(const cvol_keyword *words, size_t count, const char *word, int *value);

/* The fields that a reader knows; it skips others. Several names may stand for one field: messages
 * use the first. */
typedef struct cvol_text_layout {
    const char *line; /* the form of a line, for messages */
    char separator;
    const cvol_keyword *names;
    size_t count;
} cvol_text_layout;

#define CVOL_TEXT_FIELDS_MAX 32

typedef struct cvol_text_header {
    cvol_context *context;
    const char *path;
    const cvol_text_layout *layout;
    cvol_header lines; /* lines.at: the end of the header, once it has been read */
    const char *value[CVOL_TEXT_FIELDS_MAX]; /* NULL: the header has no such field */
} cvol_text_header;

/* Reads the file's beginning. The caller closes the header, also after a failure. */
int cvol_text_header_open(cvol_context *context, cvol_text_header *header,
                          const cvol_text_layout *layout, const char *path);
void cvol_text_header_close(cvol_text_header *header);

/* Stores the field of a line. FORMAT error: the line has no separator, or repeats a field. */
int cvol_text_header_put(cvol_text_header *header, char *line);
/* FORMAT error: one of these fields is missing. */
int cvol_text_header_need(const cvol_text_header *header, const int *fields, size_t count);

/* "PATH: FIELD 'VALUE' PROBLEM", as a FORMAT or an UNSUPPORTED error. */
int cvol_text_header_fail(const cvol_text_header *header, int field, const char *problem);
int cvol_text_header_unsupported(const cvol_text_header *header, int field, const char *problem);

/* Values of fields. A field that is missing leaves *out as it is. `count_name` states the source of
 * the count, for messages. */
int cvol_text_header_integer(const cvol_text_header *header, int field, int64_t min, int64_t max,
                             int64_t *out);
int cvol_text_header_numbers(const cvol_text_header *header, int field, double *out, size_t count,
                             const char *count_name);
int cvol_text_header_sizes(const cvol_text_header *header, int field, size_t *out, size_t count,
                           const char *count_name);

/* UNSUPPORTED error: the field names several data files. */
int cvol_text_header_one_file(const cvol_text_header *header, int field);
/* Opens the samples' file, which the field names relative to the header's folder. */
int cvol_text_header_detach(const cvol_text_header *header, int field, cvol_stored *stored);
/* Reads the number of bytes before the samples. -1: raw samples are the last bytes of the file;
 * *bytes is 0 then. */
int cvol_text_header_skip(const cvol_text_header *header, int field, cvol_stored *stored,
                          uint64_t *bytes);

#endif
