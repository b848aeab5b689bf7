/* Makes a .cvol file from a file of another format: like cvol compress --fast, with effort fast and
 * ratio 30. JavaScript calls it in a worker of its own, whose memory ends with it. */
#include <emscripten.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "cvol/cvol.h"
#include "volume/formats/zarr/labels.h"
#include "volume/io/format.h"
#include "volume/io/module.h"

static struct {
    char message[1024];
    void *bytes;
    size_t size;
} result;

static int is_dicom(const uint8_t *head, size_t size)
{
    return size >= 132 && !memcmp(head + 128, "DICM", 4);
}

const cvol_format cvol_format_dicom = {
    .name = "DICOM", .endings = {".dcm"}, .lacks = "a reader of it", .recognise = is_dicom};

/* A page gets files, not folders. */
const cvol_format cvol_format_zarr = {
    .name = "Zarr", .endings = {".zarr"}, .lacks = "a reader of it"};
const cvol_format cvol_format_pictures = {.name = "folder of pictures", .lacks = "a reader of it"};

int cvol_zarr_find_label_mark(cvol_context *context, int *out, const char *path)
{
    (void)context, (void)path;
    *out = 0;
    return CVOL_OK;
}

/* There are no modules in a page. */
void *cvol_module_find(const char *module, const char *symbol)
{
    (void)module, (void)symbol;
    return NULL;
}

EM_JS(void, report, (const char *what, double fraction), {
    if (Module.onProgress)
        Module.onProgress(UTF8ToString(what), fraction);
});

static int on_progress(void *user, const char *what, double fraction)
{
    (void)user;
    report(what ? what : "", fraction);
    return 0;
}

/* Labels stay exact; samples of a value far from all others count as missing. */
static int compress(cvol_context *context, cvol_array **out, cvol_volume *volume, const char *path)
{
    cvol_compress_options options = cvol_compress_options_defaults();
    cvol_histogram histogram;
    const int code = cvol_volume_compute_histogram(context, &histogram, volume);
    if (code)
        return code;
    options.background = CVOL_BACKGROUND_FIND;
    options.effort = CVOL_EFFORT_FAST;
    options.has_fill = histogram.mark_count > 0;
    options.fill = histogram.mark;
    options.lossless = !options.has_fill && cvol_volume_is_labels(volume, path);
    return cvol_compress(context, out, NULL, volume->data, &volume->grid, &options);
}

static int convert(cvol_context *context, const char *path)
{
    cvol_volume *volume = NULL;
    cvol_array *array = NULL;
    const cvol_read_options read = cvol_read_options_defaults();
    if (!cvol_file_is_volume(path))
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "%s: is not a volume in a format that this page reads", path);
    int code = cvol_volume_read(context, &volume, path, &read);
    if (!code)
        code = compress(context, &array, volume, path);
    cvol_volume_free(volume);
    if (!code)
        code = cvol_array_write_memory(context, array, &result.bytes, &result.size);
    cvol_array_free(array);
    return code;
}

/* The sentence of a failure; "": the result is there. */
EMSCRIPTEN_KEEPALIVE const char *convert_file(const char *path)
{
    cvol_context *context = cvol_context_create();
    if (!context)
        return "not enough memory";
    cvol_context_set_threads(context, 1);
    cvol_context_set_progress(context, on_progress, NULL);
    if (convert(context, path))
        snprintf(result.message, sizeof result.message, "%s", cvol_context_message(context));
    cvol_context_free(context);
    return result.message;
}

EMSCRIPTEN_KEEPALIVE const void *converted_bytes(void)
{
    return result.bytes;
}

EMSCRIPTEN_KEEPALIVE size_t converted_size(void)
{
    return result.size;
}
