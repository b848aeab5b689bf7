/* The table of formats; reading and writing volumes by it. */
#define _GNU_SOURCE
#include <locale.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "volume/dense.h"
#include "volume/format.h"
#include "volume/text.h"

static const cvol_format *const formats[] = {
    &cvol_format_nrrd,
    &cvol_format_nifti,
    &cvol_format_metaimage,
    &cvol_format_raw,
};

#define FORMATS (sizeof formats / sizeof formats[0])

const char *cvol_volume_formats(void)
{
    return ".nrrd .nhdr .nii .nii.gz .mha .mhd .raw";
}

cvol_read_options cvol_read_options_defaults(void)
{
    return (cvol_read_options){.dims = {0, 0, 0}};
}

static const cvol_format *format_of_name(const char *path)
{
    for (size_t f = 0; f < FORMATS; f++)
        for (int e = 0; e < 4 && formats[f]->endings[e]; e++)
            if (cvol_text_ends(path, formats[f]->endings[e]))
                return formats[f];
    return NULL;
}

/* What the file's first bytes say goes before what its name says. */
static int find_format(cvol_context *context, const cvol_format **out, const char *path)
{
    uint8_t head[CVOL_FORMAT_HEAD_BYTES];
    size_t size;
    *out = NULL;
    int code = cvol_file_peek(context, head, &size, sizeof head, path);
    if (code)
        return code;
    for (size_t f = 0; f < FORMATS && !*out; f++)
        if (formats[f]->recognise && formats[f]->recognise(head, size))
            *out = formats[f];
    if (!*out)
        *out = format_of_name(path);
    return CVOL_OK;
}

int cvol_file_is_volume(const char *path)
{
    cvol_context context = {.limit_bytes = 0}; /* for a message that nobody reads */
    const cvol_format *format;
    return !find_format(&context, &format, path) && format && !format->needs_options;
}

static int any_option(const cvol_read_options *o)
{
    return o->dims[0] || o->dims[1] || o->dims[2] || o->type || o->big_endian || o->spacing[0] ||
           o->spacing[1] || o->spacing[2];
}

static int read_any(cvol_context *context, cvol_volume **out, const char *path,
                    const cvol_read_options *options)
{
    const cvol_format *format;
    int code = find_format(context, &format, path);
    if (code)
        return code;
    if (!format && !any_option(options))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: no volume that is known by content or name (%s); raw samples need "
                         "--dims NXxNYxNZ and --type",
                         path, cvol_volume_formats());
    if (!format)
        format = &cvol_format_raw;
    if (!format->needs_options && any_option(options))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: is a %s file, which describes itself: dims, type, byte order and "
                         "spacing are for raw samples",
                         path, format->name);
    return format->read(context, out, path, options);
}

static int write_any(cvol_context *context, const cvol_volume *volume, const char *path)
{
    const cvol_format *format = format_of_name(path);
    if (!format)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "%s: the name's ending is none of those that can be written (%s)", path,
                         cvol_volume_formats());
    int code = cvol_dense_check(context, volume, path);
    return code ? code : format->write(context, volume, path);
}

/* The numbers of text headers have points whatever the user's language is. uselocale speaks for
 * this thread alone. */
static int enter_c_locale(cvol_context *context, locale_t *c, locale_t *before)
{
    *c = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!*c)
        return cvol_fail_memory(context, 0, "a locale");
    *before = uselocale(*c);
    return CVOL_OK;
}

static void leave_c_locale(locale_t c, locale_t before)
{
    uselocale(before);
    freelocale(c);
}

int cvol_volume_read(cvol_context *context, cvol_volume **out, const char *path,
                     const cvol_read_options *options)
{
    *out = NULL;
    const cvol_read_options none = cvol_read_options_defaults();
    locale_t c = (locale_t)0, before = (locale_t)0;
    int code = enter_c_locale(context, &c, &before);
    if (code)
        return code;
    code = read_any(context, out, path, options ? options : &none);
    leave_c_locale(c, before);
    return code;
}

int cvol_volume_write(cvol_context *context, const cvol_volume *volume, const char *path)
{
    locale_t c = (locale_t)0, before = (locale_t)0;
    int code = enter_c_locale(context, &c, &before);
    if (code)
        return code;
    code = write_any(context, volume, path);
    leave_c_locale(c, before);
    return code;
}
