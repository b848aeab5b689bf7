/* cvol decompress: from a .cvol file to a dense volume, slab by slab. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/base/picture.h"
#include "tools/compress/decompress.h"
#include "tools/labels/labels.h"

static const char description[] =
    "Decodes a .cvol file into a volume of the original sample type and geometry. The\n"
    "extension of OUT chooses the format. --box decodes a part; its position in the world\n"
    "stays the same. Large volumes are decoded slab by slab, in little memory. A folder\n"
    "OUT.ome.zarr gets all times and channels, unless --time or --channel chooses, and coarser\n"
    "levels. OUT.ome.tif gets all times and channels too, as OME-TIFF. OUT.seg.nrrd gets labels\n"
    "as segments of 3D Slicer, with their names and colours. OUT.h5:/group/name names the dataset\n"
    "of a new HDF5 file, instead of /data. A compressed picture becomes a PNG.";

static const char examples[] =
    "  cvol decompress brain.cvol brain.nii.gz\n"
    "  cvol decompress brain.cvol brain.nrrd\n"
    "  cvol decompress brain.cvol part.nrrd --box 100:200,150:250,90:91\n"
    "  cvol decompress cell.cvol cell.ome.zarr\n"
    "  cvol decompress brain.cvi brain.png\n";

/* 1 if a format has the extension of the name; checked before any work. */
static int can_be_written(const char *path)
{
    char ending[16];
    int length;
    if (path[cvol_volume_writer_file_length(path)]) /* OUT.h5:/dataset */
        return 1;
    for (const char *next = cvol_volume_formats(); sscanf(next, "%15s%n", ending, &length) == 1;
         next += length)
        if (has_ending(path, ending))
            return 1;
    return 0;
}

/* Memory for the samples of one slab, or for one layer of bricks if that takes more. */
#define SLAB_BYTES ((size_t)64 << 20)
enum { LAP_REACH = 2 };

/* One thread reads boxes of at most this many bricks of 64^3: starting threads, and waiting for
 * them on a busy machine, takes longer than they save. */
enum { FEW_BRICKS = 32, BRICK_SAMPLES = 64 * 64 * 64 };

int open_slab(cvol_context *context, cvol_array **array, const part *p, size_t first, size_t end)
{
    const size_t from[3] = {p->begin[0], p->begin[1], first}, to[3] = {p->end[0], p->end[1], end};
    cvol_file_part file = {.size = sizeof(cvol_file_part),
                           .begin = from,
                           .end = to,
                           .level = p->level,
                           .time = p->time,
                           .channel = p->channel};
    if (!p->is_box && first == p->begin[2] && end == p->end[2])
        file.begin = file.end = NULL; /* all: the reader then checks the whole file */
    return cvol_array_read_part(context, array, NULL, p->path, &file);
}

/* Finds grid and bricks of the file's volume by reading the brick of its first sample. */
static int find_part(cvol_context *context, part *p, const size_t *box)
{
    static const size_t zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};
    const cvol_file_part file = {.size = sizeof(cvol_file_part),
                                 .begin = zero,
                                 .end = one,
                                 .level = p->level,
                                 .time = p->time,
                                 .channel = p->channel};
    cvol_array *array;
    cvol_array_info info;
    int code = cvol_array_read_part(context, &array, NULL, p->path, &file);
    if (code)
        return code;
    cvol_array_get_info(&info, array);
    const cvol_grid *all = cvol_array_grid(array);
    p->by_slab = info.brick[0] != 0;
    p->is_exact = is_exact(info.psnr_db);
    memcpy(p->brick, info.brick, sizeof p->brick);
    for (int a = 0; a < 3; a++) {
        p->begin[a] = box ? box[2 * a] : 0;
        p->end[a] = box ? box[2 * a + 1] : all->dims[a];
    }
    p->grid = *all;
    cvol_array_free(array);
    int wrong = 0;
    for (int a = 0; a < 3; a++)
        wrong |= p->begin[a] >= p->end[a] || p->end[a] > p->grid.dims[a];
    if (wrong) { /* for the message of the library */
        code = open_slab(context, &array, p, p->begin[2], p->end[2]);
        cvol_array_free(array);
    } else if (box) {
        p->grid = cvol_grid_box(&p->grid, p->begin, p->end);
    }
    return code;
}

/* The number of bricks along one axis that the samples begin .. end - 1 depend on. */
static size_t bricks_along(size_t begin, size_t end, size_t brick)
{
    const size_t first = begin < LAP_REACH ? 0 : (begin - LAP_REACH) / brick;
    return (end + LAP_REACH - 1) / brick + 1 - first;
}

static int has_few_bricks(const part *p)
{
    double samples = 1;
    for (int a = 0; a < 3; a++)
        samples *= (double)(p->brick[a] * bricks_along(p->begin[a], p->end[a], p->brick[a]));
    return samples <= (double)FEW_BRICKS * BRICK_SAMPLES;
}

/* The end of the slab that begins at slice `first`: two slices before the end of a layer of bricks.
 * In lapped volumes the last two slices of a layer depend on the next layer too. */
static size_t slab_end(const part *p, size_t first)
{
    const size_t slice = cvol_grid_bytes(&p->grid) / p->grid.dims[2];
    const size_t brick = p->brick[2];
    if (!p->by_slab)
        return p->end[2];
    const size_t layers = SLAB_BYTES / brick / slice ? SLAB_BYTES / brick / slice : 1;
    const size_t end = ((first + LAP_REACH) / brick + layers) * brick - LAP_REACH;
    return end < p->end[2] ? end : p->end[2];
}

/* Tells the writer which values of the box mark samples without a value. */
static int note_missing(cvol_context *context, cvol_volume_writer *sink, const cvol_array *array,
                        void *samples, const size_t from[3], const size_t to[3])
{
    enum { STEP = 1024 }; /* along a row */
    const cvol_volume box = {.grid = *cvol_array_grid(array), .data = samples};
    cvol_array_info info;
    uint8_t which[STEP], is_known[256] = {0};
    int code = 0;
    cvol_array_get_info(&info, array);
    if (!info.missing_samples)
        return 0;
    const size_t width = to[0] - from[0], height = to[1] - from[1];
    for (size_t row = 0; row < height * (to[2] - from[2]); row++)
        for (size_t x = 0; x < width; x += STEP) {
            const size_t end = x + STEP < width ? x + STEP : width;
            const size_t y = from[1] + row % height, z = from[2] + row / height;
            const size_t first[3] = {from[0] + x, y, z}, last[3] = {from[0] + end, y + 1, z + 1};
            cvol_array_evaluate_mask(which, array, first, last);
            for (size_t i = x; i < end && !code; i++)
                if (which[i - x] && !is_known[which[i - x]]) {
                    is_known[which[i - x]] = 1;
                    code = cvol_volume_writer_add_missing(context, sink,
                                                          value_at(&box, width * row + i));
                }
        }
    return code;
}

static int write_slabs(cvol_context *context, const part *p, cvol_volume_writer *sink,
                       void **samples)
{
    const size_t slice = cvol_grid_bytes(&p->grid) / p->grid.dims[2];
    size_t capacity = 0;
    int code = 0;
    for (size_t first = p->begin[2], end; first < p->end[2] && !code; first = end) {
        cvol_array *array;
        end = slab_end(p, first);
        const size_t from[3] = {p->begin[0], p->begin[1], first};
        const size_t to[3] = {p->end[0], p->end[1], end};
        if (first > p->begin[2] || end < p->end[2])
            override_progress("decompressing",
                              (double)(first - p->begin[2]) / (double)p->grid.dims[2]);
        if ((end - first) * slice > capacity) {
            capacity = (end - first) * slice;
            free(*samples);
            if (!(*samples = malloc(capacity)))
                return CVOL_ERROR_MEMORY;
        }
        code = open_slab(context, &array, p, first, end);
        if (!code)
            code = cvol_array_evaluate_box(context, *samples, array, from, to);
        if (!code && p->has_levels)
            code = note_missing(context, sink, array, *samples, from, to);
        cvol_array_free(array);
        if (!code)
            code = cvol_volume_writer_write(context, sink, *samples, end - first);
    }
    override_progress(NULL, 0);
    return code;
}

static int report_json(const part *p, const char *out_path, double decode_ms)
{
    json_t *object = json_pack(
        "{s:o, s:s, s:[f, f], s:b, s:o, s:I, s:f}", "dims", json_dims(p->grid.dims), "type",
        cvol_type_name(p->grid.type), "rescale", p->grid.value_scale, p->grid.value_offset,
        "rescale_lost", loses_rescale(p, out_path), "geometry_lost", json_lost_places(p, out_path),
        "file_bytes", (json_int_t)file_size(out_path), "decode_ms", decode_ms);
    if (p->is_box && object) {
        json_object_set_new(object, "begin", json_dims(p->begin));
        json_object_set_new(object, "end", json_dims(p->end));
    }
    return print_json(object);
}

/* Writes all volumes of the part. */
static int write_volumes(cvol_context *context, const part *p, cvol_volume_writer *sink,
                         void **samples)
{
    int code = 0;
    for (int i = 0; i < p->times * p->channels && !code; i++) {
        part one = *p;
        one.time += i / p->channels;
        one.channel += i % p->channels;
        code = write_slabs(context, &one, sink, samples);
    }
    return code;
}

static void print_report(const part *p, const char *out_path)
{
    printf("%s: ", out_path);
    if (p->times > 1)
        printf("%d times, ", p->times);
    if (p->channels > 1)
        printf("%d channels, ", p->channels);
    printf("%zu x %zu x %zu samples of %s", p->grid.dims[0], p->grid.dims[1], p->grid.dims[2],
           cvol_type_name(p->grid.type));
    if (loses_rescale(p, out_path))
        printf(
            "; the format cannot store that a sample s means %.7g s %c %.7g (NIfTI and MetaImage "
            "can)",
            p->grid.value_scale, p->grid.value_offset < 0 ? '-' : '+', fabs(p->grid.value_offset));
    print_lost_places(p, out_path);
    printf("\n");
}

/* Chooses the volumes of the file: one, or for a format of series all. */
static int choose_part(cvol_context *context, common_options *common, part *p, int is_image)
{
    cvol_file_part chosen = {.size = sizeof(cvol_file_part)};
    if (!is_cvol(p->path))
        return EXIT_DONE; /* reading gives the message */
    if (is_image)
        return choose_volumes(context, common, p);
    const int status = choose_volume(context, common, p->path, &chosen);
    p->time = chosen.time;
    p->channel = chosen.channel;
    return status;
}

/* box NULL: the whole volume. name: out_path, or a dataset in it. */
static int decompress_to(cvol_context *context, common_options *common, const size_t *box,
                         int zarr_format, const char *in_path, const char *out_path,
                         const char *name)
{
    part p = {.path = in_path,
              .level = common->level,
              .is_box = box != NULL,
              .times = 1,
              .channels = 1,
              .zarr_format = zarr_format};
    cvol_volume_writer *sink = NULL;
    volume_labels labels = {0};
    void *samples = NULL;
    const int is_image = holds_series(out_path);
    p.has_levels = is_image;
    int status = check_output(in_path, out_path);
    if (!status)
        status = choose_part(context, common, &p, is_image);
    if (status)
        return status;
    const double start = milliseconds();
    if (box) /* find_part reads one brick */
        cvol_context_set_threads(context, 1);
    int code = find_part(context, &p, box);
    if (box && !(p.by_slab && has_few_bricks(&p)))
        cvol_context_set_threads(context, common->threads);
    if (!code && is_image)
        status = open_image(context, &sink, &labels, &p, common, out_path);
    else if (!code && has_ending(out_path, ".seg.nrrd"))
        status = open_segments(context, &sink, &p, out_path);
    else if (!code)
        code = cvol_volume_writer_open(context, &sink, name, &p.grid);
    if (!code && !status)
        code = write_volumes(context, &p, sink, &samples);
    const double decode_ms = milliseconds() - start;
    const int no_memory = code == CVOL_ERROR_MEMORY && !samples;
    free(samples);
    if (code || status)
        cvol_volume_writer_abandon(sink);
    else
        code = cvol_volume_writer_commit(context, sink);
    free_labels(&labels);
    if (status)
        return status;
    if (no_memory)
        return report_error(EXIT_FAILED, "%s: not enough memory for a slab of samples", in_path);
    if (code)
        return report_context_error(context, code, NULL);
    clear_progress();
    if (common->json)
        return report_json(&p, out_path, decode_ms);
    print_report(&p, out_path);
    return EXIT_DONE;
}

static int decompress(cvol_context *context, common_options *common, const size_t *box,
                      int zarr_format, const char *in_path, const char *name)
{
    char *file = strndup(name, cvol_volume_writer_file_length(name));
    if (!file)
        return report_error(EXIT_FAILED, "%s: not enough memory", name);
    const int status = decompress_to(context, common, box, zarr_format, in_path, file, name);
    free(file);
    return status;
}

/* A folder's name without the slash that a shell adds; other names stay. */
static void trim_folder(char *path)
{
    size_t length = strlen(path);
    while (length > 1 && path[length - 1] == '/')
        length--;
    if (length >= 5 && !strncmp(path + length - 5, ".zarr", 5))
        path[length] = '\0';
}

int command_decompress(int argc, char **argv)
{
    common_options common = COMMON_DEFAULTS;
    size_t box[6];
    int box_given = 0, zarr_format = 0;
    const option_spec specs[] = {
        {NULL, NULL, "Part:", OPTION_HEADING, NULL, 0, NULL},
        {"--box", "X0:X1,Y0:Y1,Z0:Z1", "only samples with X0 <= x < X1, and so on (default: all)",
         OPTION_BOX, box, 0, &box_given},
        {"--level", "L",
         "0 (default): all frequencies; 1, 2, 3: the lowest 1/2, 1/4, 1/8 of each axis",
         OPTION_INTEGER, &common.level, 0, NULL},
        PLACE_OPTIONS(common),
        {NULL, NULL, "Format:", OPTION_HEADING, NULL, 0, NULL},
        {"--zarr-format", "F",
         "of OUT.zarr: 2 (default), which is OME-Zarr 0.4, or 3, OME-Zarr 0.5", OPTION_INTEGER,
         &zarr_format, 2, NULL},
        COMMON_OPTIONS(common),
    };
    command_line line = {.usage = "cvol decompress IN OUT [options]",
                         .description = description,
                         .examples = examples,
                         .options = specs,
                         .option_count = sizeof specs / sizeof *specs,
                         .positional_count = 2};
    for (int i = 0; i < argc; i++)
        trim_folder(argv[i]);
    int status = parse_command_line(&line, argc, argv);
    if (status >= 0)
        return status;
    if (common.level > 3)
        return report_error(EXIT_MISUSED, "--level is %d, must be 0 to 3", common.level);
    const char *in_path = line.positionals[0], *out_path = line.positionals[1];
    if (zarr_format > 3)
        return report_error(EXIT_MISUSED, "--zarr-format is %d, must be 2 or 3", zarr_format);
    if (zarr_format && !has_ending(out_path, ".zarr"))
        return report_error(EXIT_MISUSED,
                            "%s: is no folder of Zarr (.zarr): leave out --zarr-format", out_path);
    const cvol_file_kind kind = kind_of(in_path);
    const int is_compressed = kind == CVOL_FILE_PICTURE ||
                              (kind == CVOL_FILE_OTHER && has_ending(out_path, ".png"));
    if (is_compressed && (box_given || common.level))
        return report_error(EXIT_MISUSED,
                            "%s: is a compressed picture: leave out --box and --level", in_path);
    if (is_compressed && !has_ending(out_path, ".png"))
        return report_error(EXIT_MISUSED,
                            "%s: is a compressed picture: the output's name must end in .png",
                            in_path);
    if (!is_compressed && !can_be_written(out_path))
        return report_error(EXIT_MISUSED, "%s: unknown extension: give one of %s", out_path,
                            cvol_volume_formats());
    cvol_context *context = begin_command(&common);
    if (!context)
        return EXIT_FAILED;
    const size_t *of = box_given ? box : NULL;
    return end_command(
        context, is_compressed ? decompress_picture(context, in_path, out_path, common.json)
                               : decompress(context, &common, of, zarr_format, in_path, out_path));
}
