/* Fuzzing of the volume readers (NIfTI, NRRD, MetaImage, TIFF, DICOM, NumPy, MRC, MGH, VTK: by
 * content): any bytes must give a volume or an error with a message. CVOL_FUZZ_FORMAT may name one
 * of them, as in its message ("NIfTI", "VTK XML"): bytes of other formats are then skipped, so that
 * the run tests only that reader; "raw" reads any bytes as raw samples of options that the first
 * bytes choose. "HDF5" is read only by that name: its library loses memory, loops and falls over
 * damaged files by itself, which would end all other readers' runs. */
#include <string.h>

#include "fuzz_file.h"
#include "volume/formats/analyze_mat.h"
#include "volume/formats/label_list.h"
#include "volume/io/format.h"

static const cvol_format *const formats[] = {
    &cvol_format_nrrd,  &cvol_format_nifti,  &cvol_format_metaimage, &cvol_format_tiff,
    &cvol_format_dicom, &cvol_format_npy,    &cvol_format_mrc,       &cvol_format_vtk,
    &cvol_format_vti,   &cvol_format_hdf5,   &cvol_format_mgh,       &cvol_format_analyze,
    &cvol_format_vdb,   &cvol_format_matlab, /* in the order of reader.c */
};

static const char *wanted;
static const cvol_format *only;

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc, (void)argv;
    wanted = getenv("CVOL_FUZZ_FORMAT");
    if (wanted && !wanted[0])
        wanted = NULL;
    if (wanted && !strcmp(wanted, "raw"))
        only = &cvol_format_raw;
    for (size_t f = 0; wanted && f < sizeof formats / sizeof *formats; f++)
        if (!strcmp(wanted, formats[f]->name))
            only = formats[f];
    if (wanted && !only) {
        fprintf(stderr, "CVOL_FUZZ_FORMAT=%s: no such format\n", wanted);
        exit(2);
    }
    return 0;
}

/* 1 if the file, which begins like this, is not of the tested format. An HDF5 file may begin with
 * bytes that other formats accept. */
static int is_other(const uint8_t *data, size_t size)
{
    const size_t head = size < CVOL_FORMAT_HEAD_BYTES ? size : CVOL_FORMAT_HEAD_BYTES;
    const cvol_format *first = NULL;
    if (only && !only->recognise) /* raw: without geometry, the geometry that the bytes seem to have
                                     is read */
        return cvol_format_hdf5.recognise(data, head);
    for (size_t f = 0; f < sizeof formats / sizeof *formats && !first; f++)
        if (formats[f]->recognise && formats[f]->recognise(data, head))
            first = formats[f];
    return only ? first != only : first == &cvol_format_hdf5;
}

/* Raw samples: up to 255 along each axis, any type and byte order. */
static cvol_read_options raw_options(const uint8_t *data, size_t size)
{
    cvol_read_options o = cvol_read_options_defaults();
    uint8_t said[5] = {0};
    memcpy(said, data, size < sizeof said ? size : sizeof said);
    for (int a = 0; a < 3; a++)
        o.dims[a] = said[a];
    o.type = (cvol_type)(said[3] % 10);
    o.big_endian = said[4] & 1;
    return o;
}

/* Names of labels, by either reader: what is no such file has none. */
static void list_labels(cvol_context *context, const char *name)
{
    int (*const readers[])(cvol_context *, cvol_label_list *,
                           const char *) = {cvol_nifti_list_labels, cvol_mgh_list_labels};
    for (size_t i = 0; i < sizeof readers / sizeof *readers; i++) {
        cvol_label_list list = {0};
        const int code = readers[i](context, &list, name);
        if (code && !cvol_context_message(context)[0])
            abort();
        for (size_t l = 0; l < list.count; l++)
            if (!memchr(list.labels[l].name, 0, sizeof list.labels[l].name))
                abort();
        free(list.labels);
    }
}

/* The same for the matrix that SPM stores next to an image. */
static void read_matrix(cvol_context *context, const char *name)
{
    cvol_grid grid = cvol_grid_make(1, 1, 1, CVOL_UINT8);
    const int code = cvol_analyze_read_mat(context, &grid, name);
    if (code ? !cvol_context_message(context)[0] : cvol_grid_check(context, &grid, name))
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char name[64];
    if (is_other(data, size))
        return 0;
    const cvol_read_options raw = raw_options(data, size);
    if (!fuzz_write_file(name, data, size))
        return 0;
    cvol_context *context = fuzz_context();
    cvol_volume *volume = NULL;
    int code = cvol_volume_read(context, &volume, name, only == &cvol_format_raw ? &raw : NULL);
    if (code == CVOL_ERROR_ARGUMENT && only != &cvol_format_raw) { /* there are several */
        const cvol_read_options first = {
            .size = sizeof(cvol_read_options), .has_channel = 1, .has_index = 1};
        code = cvol_volume_read(context, &volume, name, &first);
    }
    if (code) {
        if (!cvol_context_message(context)[0])
            abort();
    } else {
        cvol_volume_statistics stats;
        if (cvol_volume_compute_statistics(context, &stats, volume))
            abort();
    }
    cvol_volume_free(volume);
    list_labels(context, name);
    read_matrix(context, name);
    cvol_context_free(context);
    return 0;
}
