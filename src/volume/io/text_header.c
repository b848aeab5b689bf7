/* Text headers of named fields: lines, values and data files. */
#include "volume/io/text_header.h"

#include <string.h>

#include "base/context.h"

int cvol_keyword_find(const cvol_keyword *words, size_t count, const char *word, int *value)
{
    for (size_t i = 0; i < count; i++)
        if (cvol_text_equal(word, words[i].word)) {
            *value = words[i].value;
            return 1;
        }
    return 0;
}

/* The first name of a field. */
static const char *name_of(const cvol_text_header *header, int field)
{
    const cvol_keyword *name = header->layout->names;
    while (name->value != field)
        name++;
    return name->word;
}

int cvol_text_header_fail(const cvol_text_header *header, int field, const char *problem)
{
    return cvol_fail(header->context, CVOL_ERROR_FORMAT, "%s: %s '%.80s' %s", header->path,
                     name_of(header, field), header->value[field], problem);
}

int cvol_text_header_unsupported(const cvol_text_header *header, int field, const char *problem)
{
    cvol_text_header_fail(header, field, problem);
    return CVOL_ERROR_UNSUPPORTED;
}

/* ---- lines --------------------------------------------------------------------------- */

int cvol_text_header_open(cvol_context *context, cvol_text_header *header,
                          const cvol_text_layout *layout, const char *path)
{
    *header = (cvol_text_header){.context = context, .path = path, .layout = layout};
    return cvol_header_open(context, &header->lines, path);
}

void cvol_text_header_close(cvol_text_header *header)
{
    cvol_header_close(&header->lines);
}

int cvol_text_header_put(cvol_text_header *header, char *line)
{
    const cvol_text_layout *layout = header->layout;
    char *separator = strchr(line, layout->separator);
    int field;
    if (!separator)
        return cvol_fail(header->context, CVOL_ERROR_FORMAT,
                         "%s: line %zu of its header is not of the form '%s': '%.80s'",
                         header->path, header->lines.line_number, layout->line, line);
    *separator = '\0';
    const char *name = cvol_text_trim(line);
    if (!cvol_keyword_find(layout->names, layout->count, name, &field))
        return CVOL_OK;
    if (header->value[field])
        return cvol_fail(header->context, CVOL_ERROR_FORMAT, "%s: has the field '%s' twice",
                         header->path, name_of(header, field));
    header->value[field] = cvol_text_trim(separator + 1);
    return CVOL_OK;
}

int cvol_text_header_need(const cvol_text_header *header, const int *fields, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!header->value[fields[i]])
            return cvol_fail(header->context, CVOL_ERROR_FORMAT, "%s: its header has no '%s'",
                             header->path, name_of(header, fields[i]));
    return CVOL_OK;
}

/* ---- values -------------------------------------------------------------------------- */

int cvol_text_header_integer(const cvol_text_header *header, int field, int64_t min, int64_t max,
                             int64_t *out)
{
    const char *value = header->value[field];
    return value ? cvol_text_field_integer(header->context, header->path, name_of(header, field),
                                           value, min, max, out)
                 : CVOL_OK;
}

int cvol_text_header_numbers(const cvol_text_header *header, int field, double *out, size_t count,
                             const char *count_name)
{
    const char *value = header->value[field];
    return value ? cvol_text_numbers(header->context, header->path, name_of(header, field), value,
                                     out, count, count_name)
                 : CVOL_OK;
}

int cvol_text_header_sizes(const cvol_text_header *header, int field, size_t *out, size_t count,
                           const char *count_name)
{
    const char *value = header->value[field];
    return value ? cvol_text_sizes(header->context, header->path, name_of(header, field), value,
                                   out, count, count_name)
                 : CVOL_OK;
}

/* ---- data files ---------------------------------------------------------------------- */

int cvol_text_header_one_file(const cvol_text_header *header, int field)
{
    const char *file = header->value[field];
    if (file && *file && cvol_text_names_many_files(file))
        return cvol_text_header_unsupported(header, field,
                                            "is a list of files; one file can be read");
    return CVOL_OK;
}

int cvol_text_header_detach(const cvol_text_header *header, int field, cvol_stored *stored)
{
    const char *file = header->value[field];
    if (!*file)
        return cvol_text_header_fail(header, field, "names no file");
    const int code = cvol_text_header_one_file(header, field);
    if (code)
        return code;
    if (header->context->refuses_external)
        return cvol_fail(header->context, CVOL_ERROR_UNSUPPORTED,
                         "%s: field %s: the samples are in another file, %.200s, and other files "
                         "may not be opened",
                         header->path, name_of(header, field), file);
    stored->data_path = cvol_input_relative_path(header->path, file);
    if (!stored->data_path)
        return cvol_fail_memory(header->context, strlen(header->path) + strlen(file), header->path);
    stored->offset = 0;
    stored->may_go_on = 1;
    return CVOL_OK;
}

int cvol_text_header_skip(const cvol_text_header *header, int field, cvol_stored *stored,
                          uint64_t *bytes)
{
    int64_t size = 0;
    const int code = cvol_text_header_integer(header, field, -1, INT64_MAX, &size);
    if (code)
        return code;
    if (size < 0 && stored->encoding != CVOL_ENCODING_RAW)
        return cvol_text_header_fail(header, field, "is for raw samples only");
    stored->at_end = size < 0;
    *bytes = size > 0 ? (uint64_t)size : 0;
    return CVOL_OK;
}
