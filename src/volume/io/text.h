/* Text headers: their lines, and strict parsing of the numbers in them. Numbers are whole words:
 * "12abc", "" and "1e999" are refused. The decimal point is the locale's; reader.c sets the
 * thread's locale to "C" around all reading and writing of headers. */
#ifndef CVOL_VOLUME_IO_TEXT_H
#define CVOL_VOLUME_IO_TEXT_H

#include "base/bytes.h"
#include "volume/io/input.h"

/* The largest size of a header. */
#define CVOL_HEADER_LIMIT_BYTES ((size_t)1 << 20)

/* A header that is split into lines. The lines exist as long as the header is open. */
typedef struct cvol_header {
    const char *path;
    char *data;
    size_t size, at; /* at the end, `at` is the offset of attached data */
    size_t line_number;
    int whole; /* data holds the file up to its end */
} cvol_header;

/* Reads the file's beginning; the caller closes the header, also after a failure. */
int cvol_header_open(cvol_context *context, cvol_header *header, const char *path);
void cvol_header_close(cvol_header *header);
/* The next line without its end; *line is NULL after the last one. A NUL byte or a header beyond
 * the limit is a FORMAT error; other control characters become '?', fit for messages. */
int cvol_header_next(cvol_context *context, cvol_header *header, char **line);

/* Removes blanks at both ends, in place. */
char *cvol_text_trim(char *text);
/* The next word at *text and its length; *text moves behind it. NULL and 0 at the end. */
const char *cvol_text_word(const char **text, size_t *length);
/* 1 if the texts are equal except for the case of letters. */
int cvol_text_equal(const char *a, const char *b);
/* 1 if `text` ends in `ending`, except for the case of letters. */
int cvol_text_ends(const char *text, const char *ending);

/* 1 for a data file that is "LIST" or "pattern min max step": many files, not one. The text is
 * not empty. */
int cvol_text_names_many_files(const char *text);

/* Parses text[0 .. length) as one number; 1 on success. */
int cvol_text_number(const char *text, size_t length, double *out);
int cvol_text_integer(const char *text, size_t length, int64_t *out);

/* Parses exactly `count` numbers of a field, separated by blanks. `count_name` names the source of
 * the count: "x.nrrd: sizes has 2 values, dimension is 3". */
int cvol_text_numbers(cvol_context *context, const char *path, const char *field, const char *text,
                      double *out, size_t count, const char *count_name);
/* The same for sizes of axes: positive integers. */
int cvol_text_sizes(cvol_context *context, const char *path, const char *field, const char *text,
                    size_t *out, size_t count, const char *count_name);
/* A field that is one integer of min .. max. */
int cvol_text_field_integer(cvol_context *context, const char *path, const char *field,
                            const char *text, int64_t min, int64_t max, int64_t *out);

/* The shortest decimal that reads back as the same number. */
#define CVOL_TEXT_NUMBER_BYTES 32
void cvol_text_format(char out[CVOL_TEXT_NUMBER_BYTES], double value);
/* Appends `before` and this decimal. */
void cvol_text_put_number(cvol_bytes *bytes, const char *before, double value);

#endif
