/* Fuzzing of the volume readers (NIfTI, NRRD, MetaImage, TIFF, DICOM, NumPy, MRC, VTK: by content): any
 * bytes must give a volume or an error with a message. HDF5 is left out: its library, which
 * reads all of a file, loses memory where one is damaged. */
#include "fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char name[64];
    if (!fuzz_write_file(name, data, size))
        return 0;
    cvol_context *context = fuzz_context();
    cvol_volume *volume = NULL;
    int code = cvol_volume_read(context, &volume, name, NULL);
    if (code == CVOL_ERROR_ARGUMENT) { /* there are several */
        const cvol_read_options first = {.has_channel = 1, .has_index = 1};
        code = cvol_volume_read(context, &volume, name, &first);
    }
    if (code) {
        if (!cvol_context_message(context)[0])
            abort();
    } else {
        cvol_sample_stats stats;
        if (cvol_volume_stats(context, &stats, volume))
            abort();
    }
    cvol_volume_free(volume);
    cvol_context_destroy(context);
    return 0;
}
