/* cvol/mpi.h - several processes (MPI) with one volume: each draws a part of it, and the parts are
 * composited; each compresses a part of it, or computes on it. Library libcvol_mpi. */
#ifndef CVOL_MPI_H
#define CVOL_MPI_H

#include <mpi.h>

#include "cvol/codec.h"
#include "cvol/render.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The parts of a volume, one for each process of a communicator: boxes that fill the volume, by
 * halving (k-d tree) so that each has about the same matter that the transfer function shows. */
typedef struct cvol_mpi_parts cvol_mpi_parts;

/* The level of a file, 0 to 3, that suffices for cvol_mpi_parts_create, cvol_camera_fit and
 * cvol_source.whole: each process reads this level of the whole volume, and its own box with all
 * coefficients (cvol_array_read_part). */
CVOL_API int cvol_mpi_level(const cvol_grid *grid);

/* Divides a compressed volume in DCT blocks, which all processes have opened, at this level or a
 * finer one, for pictures with these options; transfer: NULL except in mode composite. Collective:
 * all processes of `comm` call it with the same arguments. The caller frees *out. Errors: those of
 * cvol_camera_fit; all processes return the same code, with a message that names the first process
 * that failed. */
CVOL_API int cvol_mpi_parts_create(cvol_context *context, cvol_mpi_parts **out,
                                   const cvol_array *array, const cvol_transfer *transfer,
                                   const cvol_render_options *options, MPI_Comm comm);
/* Collective. */
CVOL_API void cvol_mpi_parts_free(cvol_mpi_parts *parts);

/* For a process that has read the box [begin, end) of a file alone (cvol_array_read_part with
 * with_ranges), before it creates a renderer: finds the ranges of decoded samples of the blocks of
 * the box, by which renderers skip blocks, unless the file has them. All processes get the same
 * range of all samples. Without this, each renderer finds the ranges of all blocks of the volume.
 * Collective. Errors: ARGUMENT (no such box), MEMORY. */
CVOL_API int cvol_mpi_array_find_ranges(cvol_context *context, cvol_array *array,
                                        const size_t begin[3], const size_t end[3], MPI_Comm comm);

/* The box of process `rank`. */
CVOL_API cvol_part cvol_mpi_part(const cvol_mpi_parts *parts, int rank);

/* Seconds of a picture and of its stages, each that of the slowest process; messages and bytes that
 * the processes sent to each other with parts of the picture. */
typedef struct cvol_mpi_render_report {
    double total_s;     /* all stages */
    double draw_s;      /* the intermediate image of a part */
    double draw_cpu_s;  /* the same in processor time, of the busiest process */
    double all_cpu_s;   /* and of all processes together */
    double wait_s;      /* for the slowest process */
    double composite_s; /* each process gets its piece of the picture */
    double gather_s;    /* process 0 gets all pieces */
    double warp_s;      /* process 0 makes the picture of the intermediate image; of a picture that
                           is drawn in several tiles, the last one: others belong to draw_s */
    uint64_t messages, bytes;           /* of all processes */
    uint64_t most_messages, most_bytes; /* of one process */
} cvol_mpi_render_report;

/* Renders a picture of floats, without depth, by all processes: each draws its part with its own
 * renderer of engine sheet, then process 0 has the whole picture, and the images of the others are
 * undefined. The intermediate images of the parts are put together before the warp. Modes composite
 * and iso: in the order in which the eye sees the parts, each over those behind it; an interval of
 * a ray belongs to the part that has its middle. Modes mip and min: the largest and the smallest;
 * xray: sums and lengths. Collective. The picture is that of one process up to rounding (1 of 255
 * in bytes), but for composites in which one part hides another: one process takes coarser steps
 * along rays behind matter, and processes do not know what other parts hide. So their pictures are
 * a little finer, and differ by 53 dB and more in tests/cli/test_mpi.sh. Errors: those of
 * cvol_renderer_render; ARGUMENT (bytes, depth, another engine, processes on processors whose
 * instruction sets differ), LIMIT (an intermediate image above 858 million pixels). *report, if not
 * NULL in all processes, is the same in all. Cost: the picture of a part, and radix-k compositing
 * (Peterka et al., 2009): a process sends its pixels that show something, 16 bytes each, in modes
 * mip, min and xray 8, about once, and its share of the picture to process 0. Memory: that of a
 * picture, and of up to two copies of the intermediate image, as far as pixels show something;
 * *parts keeps it for the next picture. */
CVOL_API int cvol_mpi_render(cvol_context *context, cvol_mpi_render_report *report,
                             cvol_mpi_parts *parts, cvol_renderer *renderer, cvol_image *image,
                             const cvol_render_options *options);

/* Compresses samples slab by slab into the file `path`, as cvol_compress_stream, by all processes:
 * each reads and encodes every N-th layer of bricks, of 64 slices and two at either end, and
 * process 0 writes the file. It has the same bytes as the file of one process, and a target holds
 * for the whole volume. source->read is called in all processes, in each for its own layers, and
 * for a few layers in all. *report is the same in all. Collective: the same arguments in all
 * processes. Memory: that of cvol_compress_stream in each process; coded data waits in process 0.
 * Errors: those of cvol_compress_stream, of the first process that failed. */
CVOL_API int cvol_mpi_compress_stream(cvol_context *context, cvol_compress_report *report,
                                      const char *path, const cvol_sample_source *source,
                                      const cvol_grid *grid, const cvol_compress_options *options,
                                      MPI_Comm comm);

/* Processes that compute together: with a team, the work of a context is divided. */
typedef struct cvol_mpi_team cvol_mpi_team;

/* Gives the context a team: all processes of `comm`, each with a context of its own. Until
 * cvol_mpi_team_free, the following functions are collective, and each process does the work on its
 * layers of 64 slices of a volume in DCT blocks: cvol_array_add, _multiply, _compute_statistics,
 * _compare and _compute_inner_product, on operands that cvol_mpi_array_read has read;
 * cvol_array_convolve_kernel and _gradient, on an operand that is read whole; cvol_array_write, in
 * which process 0 writes the file; cvol_file_verify. Results are those of one process, and files
 * have the same bytes. A process has only its own part of a result, which can be written, and is no
 * operand. Other functions need arrays that are read without a team. `keep` of operations: NULL,
 * cvol_keep_all, _step or _loss. Errors: MEMORY; later, those of the first process that failed. A
 * process that ends its part of the work after a failure calls cvol_mpi_agree, unless
 * cvol_mpi_team_has_failed. */
CVOL_API int cvol_mpi_team_create(cvol_context *context, cvol_mpi_team **out, MPI_Comm comm);
/* Returns 1 if all processes know that one of them failed: nothing can be shared any more. */
CVOL_API int cvol_mpi_team_has_failed(const cvol_mpi_team *team);
/* Takes the team from the context, and frees it; NULL is allowed. */
CVOL_API void cvol_mpi_team_free(cvol_context *context, cvol_mpi_team *team);

/* Reads a volume as cvol_array_read_part, for the work of a team: each process reads the bricks of
 * its layers and of some slices around them. Files with a residual, a separate background or
 * samples without a value are read whole. part: time and channel; NULL: the only volume. *report
 * may be NULL. The caller frees *out. Collective. Errors: those of cvol_array_read_part;
 * UNSUPPORTED (no volume in DCT blocks). */
CVOL_API int cvol_mpi_array_read(cvol_context *context, cvol_array **out, cvol_file_report *report,
                                 const char *path, const cvol_file_part *part);

/* Checks that a file is a volume in DCT blocks, which a team can share. part: as above. Errors:
 * those of cvol_array_read_part; UNSUPPORTED. */
CVOL_API int cvol_mpi_array_check(cvol_context *context, const char *path,
                                  const cvol_file_part *part);

/* Agreement on success: collective. `code` is the caller's: CVOL_OK or an error whose message the
 * context has. If any process failed, all return the code of the first one, and *rank is its
 * number; the message of the context becomes "process R on HOST: ...", or, if all failed, that of
 * process 0. */
CVOL_API int cvol_mpi_agree(cvol_context *context, int code, int *rank, MPI_Comm comm);

#ifdef __cplusplus
}
#endif
#endif
