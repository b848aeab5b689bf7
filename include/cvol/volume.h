/* cvol/volume.h - dense volumes, their files and their samples. */
#ifndef CVOL_VOLUME_H
#define CVOL_VOLUME_H

#include "cvol/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Dense samples and their geometry. `data` holds cvol_grid_bytes(&grid) bytes in the
 * machine's byte order, x fastest (see cvol_grid), 64-byte aligned. */
typedef struct cvol_volume {
    cvol_grid grid;
    void *data;
} cvol_volume;

/* Allocates a volume of this grid, samples zero. The caller frees it with
 * cvol_volume_free. Errors: ARGUMENT, LIMIT, MEMORY. */
CVOL_API int cvol_volume_create(cvol_context *context, cvol_volume **out, const cvol_grid *grid);
/* Frees a volume; NULL is allowed. */
CVOL_API void cvol_volume_free(cvol_volume *volume);

/* How to read what a file does not say itself. */
typedef struct cvol_read_options {
    /* For raw samples (a file name that no other reader claims): all three dims and the
     * type are needed. For any other format they must stay zero. */
    size_t dims[3];
    cvol_type type;
    int big_endian;
    /* Also for formats that often do not say it (TIFF, NumPy, HDF5). 0: what the file says, or 1.
     */
    double spacing[3];
    /* Which of several channels (colours, vectors), and which of several volumes (a time series),
     * counted from 0. Without has_... the file must have but one. Arrays (NumPy, HDF5) of more than
     * three axes: v[volume, z, y, x]; v[volume, channel, z, y, x]; and where the last axis has four
     * places at most, v[z, y, x, channel] and v[volume, z, y, x, channel]. */
    int has_channel, channel;
    int has_index, index;
    /* Which of several DICOM series in a folder: its number, UID or description. NULL: the only
     * one. The text must outlive the call. */
    const char *series;
} cvol_read_options;

/* Nothing said: all is left to the file. */
CVOL_API cvol_read_options cvol_read_options_defaults(void);

/* Reads a volume; the format is recognised by content, else by name: NIfTI-1/2 (.nii, .nii.gz),
 * NRRD (.nrrd, .nhdr; raw, gzip, ascii), MetaImage (.mha, .mhd), TIFF (.tif; or a folder of
 * slices), a DICOM series (a folder, or any file of it), NumPy (.npy), MRC, VTK (.vti, and legacy
 * structured points), a dataset of HDF5 ("FILE.h5:/path/to/it"), or raw samples with options->dims
 * and options->type. options may be NULL. The caller frees *out. Cost: one pass over the file, one
 * dense volume of memory. Errors: IO, FORMAT, UNSUPPORTED, LIMIT, MEMORY, ARGUMENT, CANCELLED. */
CVOL_API int cvol_volume_read(cvol_context *context, cvol_volume **out, const char *path,
                              const cvol_read_options *options);

/* How many volumes (a time series, ...) and how many channels a file has that cvol_volume_read
 * could be asked for, with these options: of what they choose already, one. options may be NULL.
 * Cost: opening the file. Errors: those of cvol_volume_stream_open. */
CVOL_API int cvol_volume_contents(cvol_context *context, int *times, int *channels,
                                  const char *path, const cvol_read_options *options);

/* 1 if the file's content or name is that of a format that describes itself, 0 if it can only be
 * read as raw samples, or not at all. */
CVOL_API int cvol_file_is_volume(const char *path);

/* Writes a volume in its own sample type; the name's ending chooses the format: .nrrd, .nhdr,
 * .nii, .nii.gz, .mha, .mhd, .raw, .tif (which keeps spacing alone), .npy (not even that), .vti.
 * The file appears under its name only when it is whole; what
 * was there before stays until then. Errors: ARGUMENT (unknown ending), UNSUPPORTED, IO, MEMORY. */
CVOL_API int cvol_volume_write(cvol_context *context, const cvol_volume *volume, const char *path);

/* ---- by slab ----
 *
 * Volumes larger than memory: some sheets (z) at a time, read from a file and written to one.
 * Beyond the caller's samples both need less than 2 MiB of memory, whatever the volume's size is,
 * and the context's limit does not apply to it.
 */

/* A volume's file, open for reading. */
typedef struct cvol_volume_stream cvol_volume_stream;

/* Opens a file that cvol_volume_read would read, with the same options, checks and messages; of
 * the samples, only their place and number are checked here. The caller closes the stream.
 * Samples stored as text, in another order of axes (NumPy's Fortran order, MRC maps that are
 * turned) or packed by VTK cannot be read by slab: they are read whole here and held, and then the
 * context's limit applies. TIFF, DICOM and HDF5 need a sheet's memory, or a layer of chunks'.
 * Errors: as cvol_volume_read. */
CVOL_API int cvol_volume_stream_open(cvol_context *context, cvol_volume_stream **out,
                                     const char *path, const cvol_read_options *options);
/* The file's grid, as long as the stream is open. */
CVOL_API const cvol_grid *cvol_volume_stream_grid(const cvol_volume_stream *stream);
/* How far apart the volumes of the file's time series are, 0 if it does not say it (NIfTI's pixdim,
 * OME's TimeIncrement and ImageJ's finterval do), and in which unit: "s", "ms", ..., or "". */
CVOL_API double cvol_volume_stream_time_step(const cvol_volume_stream *stream, const char **unit);
/* What the file calls one of its channels, counted from 0 (OME's Name): UTF-8, at most 63 bytes, ""
 * if it does not say it; as long as the stream is open. */
CVOL_API const char *cvol_volume_stream_channel_name(const cvol_volume_stream *stream, int channel);
/* A channel's colour, each 0 to 1 (OME's Color). 1, or 0 if the file does not say it, and rgb stays
 * as it is. */
CVOL_API int cvol_volume_stream_channel_colour(const cvol_volume_stream *stream, int channel,
                                               double rgb[3]);
/* 1 if channels 0, 1 and 2 are red, green and blue of one colour, and channel 3, if there is one,
 * its alpha: RGB and RGBA of TIFF and NIfTI, and bytes of VTK, VTI and NumPy that lie in threes and
 * fours. 0: channels are volumes of their own. */
CVOL_API int cvol_volume_stream_colours(const cvol_volume_stream *stream);
/* Sheets first_sheet .. first_sheet + sheets - 1 into `out`, in the machine's byte order: sheets nx
 * ny samples, x fastest. Calls may come in any order, also after one that failed. Cost: one pass
 * over these samples; in compressed files (NRRD gzip, MetaImage zlib, .nii.gz) also over all that
 * lie between the last call's end and first_sheet, and to go back over all before it. Whether a
 * compressed file is whole is known when its last sheet is read.
 * Errors: IO, FORMAT, MEMORY, ARGUMENT (sheets that the volume does not have). */
CVOL_API int cvol_volume_stream_read(cvol_context *context, cvol_volume_stream *stream, void *out,
                                     size_t first_sheet, size_t sheets);
/* Closes the file and frees the stream; NULL is allowed. */
CVOL_API void cvol_volume_stream_close(cvol_volume_stream *stream);

/* A volume's file, open for writing. */
typedef struct cvol_volume_writer cvol_volume_writer;

/* Opens a file for samples of this grid: the same file, byte by byte, that cvol_volume_write would
 * write. The caller ends it with one of commit and abandon. Errors: as cvol_volume_write, and LIMIT
 * for more bytes than size_t can count. */
CVOL_API int cvol_volume_writer_open(cvol_context *context, cvol_volume_writer **out,
                                     const char *path, const cvol_grid *grid);
/* The next sheets, in order: sheets nx ny samples in the machine's byte order. After an error the
 * file can only be abandoned. Errors: IO, ARGUMENT (more sheets than the grid has: nothing was
 * written). */
CVOL_API int cvol_volume_writer_write(cvol_context *context, cvol_volume_writer *sink,
                                      const void *samples, size_t sheets);
/* Gives the file its name, when all sheets are written, and frees the sink; also when it fails,
 * and then what had the name before stays. Errors: IO, ARGUMENT (sheets are missing). */
CVOL_API int cvol_volume_writer_commit(cvol_context *context, cvol_volume_writer *sink);
/* Removes what was written and frees the sink; NULL is allowed. */
CVOL_API void cvol_volume_writer_abandon(cvol_volume_writer *sink);

/* The endings that can be written, for messages: ".nrrd .nhdr ..."; static storage. */
CVOL_API const char *cvol_volume_formats(void);
/* The endings of files that this build reads; formats whose library it lacks are not among them. */
CVOL_API const char *cvol_volume_readers(void);

/* Minimum, maximum and mean of the samples, and how many are NaN or infinite (those are left
 * out of the other three), with the index (x fastest) of the first of them. */
typedef struct cvol_sample_stats {
    double min, max, mean;
    size_t bad_count, bad_first;
} cvol_sample_stats;
/* One pass over the samples. Errors: CANCELLED. */
CVOL_API int cvol_volume_stats(cvol_context *context, cvol_sample_stats *out,
                               const cvol_volume *volume);

/* Replaces every NaN or infinite sample by `value`. Errors: ARGUMENT (the type cannot hold it). */
CVOL_API int cvol_volume_fill(cvol_context *context, cvol_volume *volume, double value);

/* How far volume b is from volume a (same dims): rmse, largest |a - b|, and
 * psnr_db = 20 log10((max a - min a) / rmse), infinity when equal. */
typedef struct cvol_volume_difference {
    double psnr_db, rmse, max_abs_error, peak;
} cvol_volume_difference;
/* One pass over both. Errors: ARGUMENT (dims differ), CANCELLED. */
CVOL_API int cvol_volume_compare(cvol_context *context, cvol_volume_difference *out,
                                 const cvol_volume *a, const cvol_volume *b);

#ifdef __cplusplus
}
#endif
#endif
