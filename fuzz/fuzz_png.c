/* Fuzzing of the PNG reader: any bytes must give a picture or an error with a message. */
#include "fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char name[64];
    /* A header may validly request a gigabyte: limit the size it can state. */
    if (size < 24 || data[16] || data[17] || data[18] > 3 || data[20] || data[21] || data[22] > 3 ||
        !fuzz_write_file(name, data, size))
        return 0;
    cvol_context *context = fuzz_context();
    cvol_image *image = NULL;
    if (cvol_image_read_png(context, &image, name) && !cvol_context_message(context)[0])
        abort();
    cvol_image_free(image);
    cvol_context_free(context);
    return 0;
}
