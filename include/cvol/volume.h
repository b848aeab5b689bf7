/* cvol/volume.h - dense volumes, their files and their samples. */
#ifndef CVOL_VOLUME_H
#define CVOL_VOLUME_H

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Dense samples and their geometry. `data` holds cvol_grid_bytes(&grid) bytes in the byte order of
 * the machine, x fastest (see cvol_grid), aligned to 64 bytes, on Windows to 16. */
typedef struct cvol_volume {
    cvol_grid grid;
    void *data;
} cvol_volume;

/* Allocates a volume of this grid; all samples are zero. The caller frees it with cvol_volume_free.
 * Errors: ARGUMENT, LIMIT, MEMORY. */
CVOL_API int cvol_volume_create(cvol_context *context, cvol_volume **out, const cvol_grid *grid);
/* Frees a volume; NULL is allowed. */
CVOL_API void cvol_volume_free(cvol_volume *volume);

/* Facts that a file does not state; start with cvol_read_options_defaults(). */
typedef struct cvol_read_options {
    size_t size; /* sizeof(cvol_read_options) */
    /* For raw samples (a file that no other reader recognizes): all dims and the type are required.
     * For other formats they must be zero. */
    size_t dims[3];
    cvol_type type;
    int big_endian;
    /* Spacing of raw samples, and of formats that often lack it (TIFF, NumPy, HDF5). 0: as in the
     * file, or 1. */
    double spacing[3];
    /* The channel (of colours or vectors) and the volume (of a time series) to read, from 0.
     * Without has_channel or has_index the file must have only one. Arrays (NumPy, HDF5) with more
     * than three axes are v[volume, z, y, x] or v[volume, channel, z, y, x]; if the last axis has
     * at most four places, v[z, y, x, channel] or v[volume, z, y, x, channel]. */
    int has_channel, channel;
    int has_index, index;
    /* The DICOM series of a folder: its number, UID or description. NULL: the only one. The text
     * must outlive the call. */
    const char *series;
    /* 1: integers of 64 bits become float64, even if all fit into 32 bits: volumes of a series need
     * one type. */
    int wide_float64;
} cvol_read_options;

/* Sets *options, which has `size` bytes, to the defaults. */
CVOL_API void cvol_read_options_set_defaults(cvol_read_options *options, size_t size);
/* No facts: the file states everything. */
static inline cvol_read_options cvol_read_options_defaults(void)
{
    cvol_read_options options;
    cvol_read_options_set_defaults(&options, sizeof options);
    return options;
}

/* Reads a volume. The content decides the format, or else the name: NIfTI-1/2 (.nii, .nii.gz), NRRD
 * (.nrrd, .nhdr; raw, gzip, ascii), MetaImage (.mha, .mhd), MGH (.mgh, .mgz), Analyze (.hdr, .img),
 * TIFF (.tif; or a folder of slices), a folder of PNG or JPEG slices, a DICOM series (a folder, or
 * any file of it), NumPy (.npy), MRC, VTK (.vti, and legacy structured points), a folder of Zarr
 * (an image of OME-Zarr, one of its levels, or an array), a dataset of HDF5
 * ("FILE.h5:/path/to/it"), MINC 2 (.mnc; values of slices with scales of their own are floats), a
 * grid of OpenVDB ("FILE.vdb:NAME": the box of its active voxels), an array of MATLAB 5 to 7.2
 * ("FILE.mat:NAME": A(x, y, z), of the type that the file stores), or raw samples with
 * options->dims and options->type. Integers of 64 bits become int32, uint32 or float64, whichever
 * first holds all exactly; complex64 of NumPy, NIfTI and Analyze becomes its magnitude. options may
 * be NULL. The caller frees *out. Cost: one pass over the file; memory for one dense volume.
 * Errors: IO, FORMAT, UNSUPPORTED, LIMIT, MEMORY, ARGUMENT, CANCELLED. */
CVOL_API int cvol_volume_read(cvol_context *context, cvol_volume **out, const char *path,
                              const cvol_read_options *options);

/* Sets *times and *channels to the numbers of volumes of a file that cvol_volume_read can read; 1
 * where the options choose one. options may be NULL. Cost: opening the file. Errors: those of
 * cvol_volume_stream_open. */
CVOL_API int cvol_file_count_volumes(cvol_context *context, int *times, int *channels,
                                     const char *path, const cvol_read_options *options);

/* Sets *out to 1 if content or name of the file is that of a format with a header, to 0 if it can
 * only hold raw samples. Errors: IO (it cannot be read, or is a folder without a volume). */
CVOL_API int cvol_file_read_is_volume(cvol_context *context, int *out, const char *path);
/* The same; 0 also for an unreadable file. */
CVOL_API int cvol_file_is_volume(const char *path);

/* Writes a volume in its sample type. The extension of the name chooses the format: .nrrd, .nhdr,
 * .nii, .nii.gz, .mha, .mhd, .raw, .tif (of the geometry only spacing, as ImageJ's metadata, or in
 * .ome.tif as OME's), .npy (no geometry), .vti, .h5 (one dataset, /data; spacing in a unit of
 * length), .mrc, .mgh, .mgz, .zarr (a folder, OME-Zarr 0.4). The file gets its name only when it is
 * complete; a file that had the name stays until then. Errors: ARGUMENT (unknown extension),
 * UNSUPPORTED, IO, MEMORY. */
CVOL_API int cvol_volume_write(cvol_context *context, const cvol_volume *volume, const char *path);

/* ---- by slab ----
 *
 * For volumes larger than memory: reads and writes some slices (z) at a time. Besides the caller's
 * samples this takes less than 2 MiB of memory for any volume, and the limit of the context does
 * not apply. */

/* A volume's file, open for reading. */
typedef struct cvol_volume_stream cvol_volume_stream;

/* Opens a file that cvol_volume_read can read, with the same options, checks and messages; it
 * checks only place and number of the samples. The caller closes the stream. Text samples, other
 * orders of axes (NumPy's Fortran order, permuted MRC maps) and packed VTK cannot be read by slab:
 * this function reads them whole, and the limit of the context applies. TIFF, DICOM, HDF5
 * and Zarr need the memory of a slice, or of a layer of chunks. Errors: as cvol_volume_read. */
CVOL_API int cvol_volume_stream_open(cvol_context *context, cvol_volume_stream **out,
                                     const char *path, const cvol_read_options *options);
/* The grid of the file; valid while the stream is open. */
CVOL_API const cvol_grid *cvol_volume_stream_grid(const cvol_volume_stream *stream);
/* The time between the volumes of a time series, and its unit: "s", "ms", ..., or "". 0: the file
 * does not state it (NIfTI's pixdim, OME's TimeIncrement and ImageJ's finterval do). */
CVOL_API double cvol_volume_stream_time_step(const cvol_volume_stream *stream, const char **unit);
/* The name of a channel, counted from 0 (OME's Name): UTF-8, at most 63 bytes; "": the file has
 * none. Valid while the stream is open. */
CVOL_API const char *cvol_volume_stream_channel_name(const cvol_volume_stream *stream, int channel);
/* Sets rgb to the colour of a channel (OME's Color), each component 0 to 1, and returns 1; or
 * returns 0, without a change, if the file has none. */
CVOL_API int cvol_volume_stream_get_channel_colour(double rgb[3], const cvol_volume_stream *stream,
                                                   int channel);
/* 1 if channels 0, 1 and 2 are red, green and blue of one colour, and channel 3, if there is one,
 * its alpha: RGB and RGBA of TIFF and NIfTI; bytes of VTK, VTI and NumPy in groups of three or
 * four. 0: each channel is a separate volume. */
CVOL_API int cvol_volume_stream_has_colours(const cvol_volume_stream *stream);
/* Reads slices first_slice .. first_slice + slices - 1 into `out`: slices nx ny samples in the byte
 * order of the machine, x fastest. Calls may be in any order, and may follow a failed one. Cost:
 * one pass over these samples. In compressed files (NRRD gzip, MetaImage zlib, .nii.gz) also over
 * those between the end of the last call and first_slice; going back reads from the start of the
 * file. The read of the last slice of a compressed file checks that the file is complete. Errors:
 * IO, FORMAT, MEMORY, ARGUMENT (no such slices). */
CVOL_API int cvol_volume_stream_read(cvol_context *context, cvol_volume_stream *stream, void *out,
                                     size_t first_slice, size_t slices);
/* 1 if the file's rows can be read on their own: raw samples, HDF5, or those that are in memory. */
CVOL_API int cvol_volume_stream_can_read_rows(const cvol_volume_stream *stream);
/* Reads rows first_row .. first_row + rows - 1 of slices first_slice .. first_slice + slices - 1
 * into `out`: slices rows nx samples, as above. Cost: these samples, if
 * cvol_volume_stream_can_read_rows; otherwise all samples of these slices and more. Errors: as
 * above. */
CVOL_API int cvol_volume_stream_read_rows(cvol_context *context, cvol_volume_stream *stream,
                                          void *out, size_t first_slice, size_t slices,
                                          size_t first_row, size_t rows);
/* Closes the file and frees the stream; NULL is allowed. */
CVOL_API void cvol_volume_stream_free(cvol_volume_stream *stream);

/* A volume's file, open for writing. */
typedef struct cvol_volume_writer cvol_volume_writer;

/* Opens a file for samples of this grid. It will hold the same bytes as from cvol_volume_write. The
 * caller ends it with commit or abandon. Errors: as cvol_volume_write, and LIMIT for more bytes
 * than size_t can count. */
CVOL_API int cvol_volume_writer_open(cvol_context *context, cvol_volume_writer **out,
                                     const char *path, const cvol_grid *grid);
/* A label of a volume: a number that names a region. */
typedef struct cvol_label {
    int value;
    const char *name; /* UTF-8 */
    double rgb[3];    /* each component 0 to 1 */
} cvol_label;

/* The same for a volume of labels, with their names and colours: `count` of them, in the order in
 * which a program lists them. They are only read here. An NRRD file has them as segments in the
 * form of 3D Slicer (.seg.nrrd), each with the extent of the whole volume, and OME-Zarr (NAME.zarr)
 * as its image-label; other files do not have them. Errors: those of cvol_volume_writer_open. */
CVOL_API int cvol_volume_writer_open_labels(cvol_context *context, cvol_volume_writer **out,
                                            const char *path, const cvol_grid *grid,
                                            const cvol_label *labels, size_t count);
/* Reads the names and colours of labels that a file states: those of AFNI and of Connectome
 * Workbench in NIfTI (.nii, .nii.gz), and the colour table in MGH and MGZ. rgb[0] is -1 where the
 * file has a name without a colour. *count: 0 if it states none, or is another file. The caller
 * frees *out with free(); the names are part of it. Errors: IO, FORMAT, LIMIT (65,536 labels),
 * MEMORY. */
CVOL_API int cvol_label_list_read(cvol_context *context, cvol_label **out, size_t *count,
                                  const char *path);
/* Writes the next slices: slices nx ny samples in the byte order of the machine. After an error
 * only abandon may follow. Errors: IO, ARGUMENT (more slices than the grid has; nothing is
 * written). */
CVOL_API int cvol_volume_writer_write(cvol_context *context, cvol_volume_writer *writer,
                                      const void *samples, size_t slices);
/* Samples that are equal to `value` have no value, in all slices that are written later. OME-Zarr
 * leaves them out of the means of its coarser levels, where a mean of none is such a value, and of
 * the ranges of its channels, as it leaves out NaN and infinity. Other files do not depend on it.
 * Errors: ARGUMENT, LIMIT (more than 64 different values). */
CVOL_API int cvol_volume_writer_add_missing(cvol_context *context, cvol_volume_writer *writer,
                                            double value);
/* Gives the complete file its name, and frees the object, after a failure too; then a file that had
 * the name stays. Errors: IO, ARGUMENT (slices are missing). */
CVOL_API int cvol_volume_writer_commit(cvol_context *context, cvol_volume_writer *writer);
/* Removes the unfinished file and frees the object; NULL is allowed. */
CVOL_API void cvol_volume_writer_abandon(cvol_volume_writer *writer);

/* The extensions that this build writes, for messages: ".nrrd .nhdr ..."; static storage. */
CVOL_API const char *cvol_volume_formats(void);
/* The extensions that this build reads; static storage. Formats whose library is missing are not
 * listed. */
CVOL_API const char *cvol_volume_readers(void);

/* Minimum, maximum and mean of the finite samples; the number of NaN and infinite samples; and the
 * index (x fastest) of the first of these. */
typedef struct cvol_volume_statistics {
    double min, max, mean;
    size_t bad_count, bad_first;
} cvol_volume_statistics;
/* Computes the statistics of a volume. Cost: one pass over the samples. Errors: CANCELLED. */
CVOL_API int cvol_volume_compute_statistics(cvol_context *context, cvol_volume_statistics *out,
                                            const cvol_volume *volume);

/* Replaces every NaN or infinite sample with `value`. Errors: ARGUMENT (the type cannot represent
 * it). */
CVOL_API int cvol_volume_fill(cvol_context *context, cvol_volume *volume, double value);

/* Makes a grid of the same box as `grid`, from the first to the last sample of every axis, that has
 * no more samples than a volume of the grid `like` needs there: at least two for each of its
 * samples. It is `grid` itself if that is not finer, or if the dims are equal. For
 * cvol_volume_resample; errors: its ARGUMENT. */
CVOL_API int cvol_grid_coarsen(cvol_context *context, cvol_grid *out, const cvol_grid *grid,
                               const cvol_grid *like);

/* Makes a volume with the dims and the geometry of `grid`, from the samples of `from` at the same
 * places in the world. If only one of the two grids has a patient orientation (cvol_grid.space), or
 * none has and the dims are equal, samples with equal indices have the same place. LPS and RAS, and
 * nm, um, mm, cm and m are converted. labels 0: linear interpolation; the result is float32, and
 * NaN outside of `from` and where its samples are. labels 1: the label that has the largest weight
 * in linear interpolation; the type is that of `from`, and 0 is outside. *inside: how many samples
 * of the result are not outside; may be NULL. The caller frees *out. Cost: one pass over the
 * result; with labels 0 also 4 bytes per sample of `from`. Errors: ARGUMENT (also without a common
 * space: only one grid has an orientation, and the dims differ), LIMIT, MEMORY. */
CVOL_API int cvol_volume_resample(cvol_context *context, cvol_volume **out, uint64_t *inside,
                                  const cvol_volume *from, const cvol_grid *grid, int labels);

/* The difference of volume b from volume a (same dims): RMSE, largest |a - b|, and psnr_db = 20
 * log10((max a - min a) / rmse), infinity if they are equal. Samples that are NaN in both, or the
 * same infinity, are left out. */
typedef struct cvol_volume_difference {
    double psnr_db, rmse, max_abs_error, peak;
} cvol_volume_difference;
/* Computes it. Cost: one pass over both. Errors: ARGUMENT (dims differ), CANCELLED. */
CVOL_API int cvol_volume_compare(cvol_context *context, cvol_volume_difference *out,
                                 const cvol_volume *a, const cvol_volume *b);

#ifdef __cplusplus
}
#endif
#endif
