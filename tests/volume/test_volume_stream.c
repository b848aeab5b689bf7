/* Volumes by slab: streams read the same as cvol_volume_read, in any order, and refuse the same
 * files with the same messages; writers write the same as cvol_volume_write. Files beyond 4 GiB. */
#include "test.h"

#include <fcntl.h>
#include <unistd.h>

#include "cvol/volume.h"
#include "random.h"
#include "support.h"
#include "support_volume.h"
#include "volume/io/format.h"

static const char *const names[] = {"a.nrrd", "a.nhdr", "a.mha", "a.mhd", "a.nii", "a.nii.gz"};
#define NAMES (sizeof names / sizeof names[0])

static size_t slice_bytes(const cvol_grid *grid)
{
    return cvol_grid_bytes(grid) / grid->dims[2];
}

/* A grid whose compressed files have several parts; few samples if `small`. */
static cvol_grid random_grid(random_state *r, int small)
{
    uint32_t most = small ? 9 : 90;
    cvol_grid grid = odd_grid((cvol_type)(CVOL_UINT8 + (int)random_below(r, 8)), 0);
    for (int a = 0; a < 3; a++)
        grid.dims[a] = 1 + random_below(r, most);
    return grid;
}

/* ---- streams ------------------------------------------------------------------------- */

/* Random slabs, also empty ones, then all in order. */
static void check_slabs(cvol_volume_stream *stream, const cvol_volume *whole, random_state *r)
{
    size_t slice = slice_bytes(&whole->grid), slices = whole->grid.dims[2], step;
    uint8_t *out = malloc(slice * slices);
    assert_non_null(out);
    for (int i = 0; i < 12; i++) {
        size_t first = random_below(r, (uint32_t)slices + 1);
        size_t count = random_below(r, (uint32_t)(slices - first) + 1);
        check_ok(cvol_volume_stream_read(context, stream, out, first, count));
        assert_memory_equal(out, (uint8_t *)whole->data + first * slice, count * slice);
    }
    for (size_t z = 0; z < slices; z += step) {
        step = 1 + random_below(r, (uint32_t)(slices - z));
        check_ok(cvol_volume_stream_read(context, stream, out, z, step));
        assert_memory_equal(out, (uint8_t *)whole->data + z * slice, step * slice);
    }
    free(out);
}

/* Random rows of random slices, also none. */
static void check_rows(cvol_volume_stream *stream, const cvol_volume *whole, random_state *r)
{
    const size_t slice = slice_bytes(&whole->grid), *dims = whole->grid.dims;
    const size_t row = slice / dims[1];
    uint8_t *out = malloc(slice * dims[2]);
    assert_non_null(out);
    for (int i = 0; i < 12; i++) {
        const size_t first[2] = {random_below(r, (uint32_t)dims[1] + 1),
                                 random_below(r, (uint32_t)dims[2] + 1)};
        const size_t rows = random_below(r, (uint32_t)(dims[1] - first[0]) + 1),
                     slices = random_below(r, (uint32_t)(dims[2] - first[1]) + 1);
        check_ok(
            cvol_volume_stream_read_rows(context, stream, out, first[1], slices, first[0], rows));
        for (size_t z = 0; z < slices; z++)
            assert_memory_equal(out + z * rows * row,
                                (uint8_t *)whole->data + (first[1] + z) * slice + first[0] * row,
                                rows * row);
    }
    assert_int_equal(cvol_volume_stream_read_rows(context, stream, out, 0, 1, 1, dims[1]),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_volume_stream_read_rows(context, stream, out, dims[2], 1, 0, 1),
                     CVOL_ERROR_ARGUMENT);
    free(out);
}

static void check_stream(const char *path, const cvol_read_options *options, random_state *r)
{
    cvol_volume *whole;
    cvol_volume_stream *stream;
    check_ok(cvol_volume_read(context, &whole, path, options));
    check_ok(cvol_volume_stream_open(context, &stream, path, options));
    const cvol_grid *grid = cvol_volume_stream_grid(stream);
    assert_memory_equal(grid->dims, whole->grid.dims, sizeof grid->dims);
    assert_int_equal(grid->type, whole->grid.type);
    assert_int_equal(grid->space, whole->grid.space);
    same_place(grid, &whole->grid, 0, 0);
    check_slabs(stream, whole, r);
    check_rows(stream, whole, r);
    cvol_volume_stream_free(stream);
    cvol_volume_free(whole);
}

static void test_written(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 8; seed++) {
        random_state r = {seed};
        cvol_grid grid = random_grid(&r, seed % 2 == 0);
        cvol_volume *volume = make_volume(&grid, seed);
        for (size_t f = 0; f < NAMES; f++) {
            check_ok(cvol_volume_write(context, volume, in_folder(names[f])));
            check_stream(in_folder(names[f]), NULL, &r);
        }
        cvol_volume_stream *stream;
        check_ok(cvol_volume_write(context, volume, in_folder("a.h5")));
        const int code = cvol_volume_stream_open(context, &stream, in_folder("a.h5"), NULL);
        if (code != CVOL_ERROR_UNSUPPORTED) { /* this build reads HDF5 */
            check_ok(code);
            cvol_volume_stream_free(stream);
            check_stream(in_folder("a.h5"), NULL, &r);
        }
        cvol_read_options options = {
            .size = sizeof(cvol_read_options), .type = grid.type, .big_endian = seed % 3 == 0};
        memcpy(options.dims, grid.dims, sizeof options.dims);
        check_stream(in_folder("a.raw"), &options, &r); /* left by .mhd */
        cvol_volume_free(volume);
    }
    cvol_volume_stream_free(NULL);
}

/* Files of other programs: the other byte order, skips, text, pairs. */
static void test_foreign(void **state)
{
    (void)state;
    random_state r = {5};
    uint8_t packed[200];
    size_t size = gzip(packed, sizeof packed, counting, 64, 15 + 16);
#define NRRD_OF(sizes, more) \
    "NRRD0004\ntype: uint16\ndimension: 3\nsizes: " sizes "\nendian: big\n" more "\n\n"
    check_stream(write_text("f.nrrd", NRRD_OF("2 3 5", "encoding: raw"), counting, 60), NULL, &r);
    check_stream(
        write_text("f.nrrd", NRRD_OF("2 3 4", "encoding: raw\nbyte skip: -1"), counting, 60), NULL,
        &r);
    check_stream(write_text("f.nrrd",
                            NRRD_OF("1 2 13", "encoding: raw\nline skip: 1\nbyte skip: 1"),
                            counting + 4, 59),
                 NULL, &r);
    check_stream(
        write_text("f.nrrd", NRRD_OF("2 3 5", "encoding: gzip\nbyte skip: 4"), packed, size), NULL,
        &r);
    write_bytes("f.raw.gz", packed, size);
    check_stream(
        write_text("f.nhdr", NRRD_OF("2 4 4", "encoding: gzip\ndata file: f.raw.gz"), NULL, 0),
        NULL, &r);
    check_stream(
        write_text("f.nrrd", NRRD_OF("1 2 4", "encoding: ascii"), "1 2 3 4 5 6 7 65535", 19), NULL,
        &r);
    check_stream(write_text("f.mha",
                            "NDims = 3\nDimSize = 4 2 4\nElementType = MET_SHORT\n"
                            "ElementByteOrderMSB = True\nElementDataFile = LOCAL\n",
                            counting, 64),
                 NULL, &r);
    size = gzip(packed, sizeof packed, counting, 64, 15);
    check_stream(write_text("f.mha",
                            "NDims = 3\nDimSize = 2 2 4\nElementType = MET_FLOAT\n"
                            "CompressedData = True\nElementDataFile = LOCAL\n",
                            packed, size),
                 NULL, &r);
    header h = nifti1(1);
    memcpy(h.bytes + 344, "ni1", 4);
    set_float(&h, 108, 0);
    write_bytes("f.img", counting, 12);
    check_stream(write_bytes("f.hdr", h.bytes, 348), NULL, &r);
}

static void test_no_such_slices(void **state)
{
    (void)state;
    const char *path = write_bytes("s.raw", counting, 60);
    cvol_read_options options = {
        .size = sizeof(cvol_read_options), .dims = {3, 4, 5}, .type = CVOL_UINT8};
    cvol_volume_stream *stream;
    uint8_t out[60];
    check_ok(cvol_volume_stream_open(context, &stream, path, &options));
    check_ok(cvol_volume_stream_read(context, stream, out, 5, 0));
    check_ok(cvol_volume_stream_read(context, stream, NULL, 2, 0));
    const size_t wrong[][2] = {{6, 0}, {5, 1}, {0, 6}, {3, 3}, {SIZE_MAX, 2}, {2, SIZE_MAX}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_int_equal(cvol_volume_stream_read(context, stream, out, wrong[i][0], wrong[i][1]),
                         CVOL_ERROR_ARGUMENT);
        assert_int_equal(strncmp(cvol_context_message(context), path, strlen(path)), 0);
    }
    assert_int_equal(cvol_volume_stream_read(context, stream, NULL, 0, 1), CVOL_ERROR_ARGUMENT);
    assert_int_equal(cvol_volume_stream_read(context, NULL, out, 0, 1), CVOL_ERROR_ARGUMENT);
    check_ok(cvol_volume_stream_read(context, stream, out, 0, 5));
    assert_memory_equal(out, counting, 60);
    cvol_volume_stream_free(stream);
}

/* ---- refusals ------------------------------------------------------------------------ */

/* Slice by slice to the end; the code of the first failure. */
static int stream_all(const char *path, const cvol_read_options *options)
{
    cvol_volume_stream *stream = (cvol_volume_stream *)&stream;
    int code = cvol_volume_stream_open(context, &stream, path, options);
    if (code) {
        assert_null(stream);
        return code;
    }
    const cvol_grid *grid = cvol_volume_stream_grid(stream);
    uint8_t *out = malloc(slice_bytes(grid));
    assert_non_null(out);
    for (size_t z = 0; !code && z < grid->dims[2]; z++)
        code = cvol_volume_stream_read(context, stream, out, z, 1);
    free(out);
    cvol_volume_stream_free(stream);
    return code;
}

/* A damaged file: the stream fails with the message of cvol_volume_read. */
static void check_refusal(const char *path, const cvol_read_options *options)
{
    cvol_volume *whole;
    char message[1024];
    int code = cvol_volume_read(context, &whole, path, options);
    snprintf(message, sizeof message, "%s", cvol_context_message(context));
    cvol_volume_free(whole);
    int got = stream_all(path, options);
    assert_int_equal(got, code);
    if (code)
        assert_string_equal(message, cvol_context_message(context));
}

/* A new file costs much less than new content of an old one on some file systems. */
static const char *write_new(const char *name, const void *data, size_t size)
{
    remove(in_folder(name));
    return write_bytes(name, data, size);
}

static void test_damage(void **state)
{
    (void)state;
    cvol_grid grid = odd_grid(CVOL_INT16, 0);
    cvol_volume *volume = make_volume(&grid, 8);
    random_state r = {78};
    for (size_t f = 0; f < NAMES; f++) {
        size_t size;
        check_ok(cvol_volume_write(context, volume, in_folder(names[f])));
        uint8_t *bytes = support_read(in_folder(names[f]), &size);
        for (size_t cut = 1; cut <= size; cut++)
            check_refusal(write_new(names[f], bytes, cut), NULL);
        cvol_context_set_limit_bytes(context, 1 << 20); /* headers lie about sizes */
        for (int i = 0; i < 1000; i++) {
            size_t at = random_below(&r, (uint32_t)size);
            uint8_t before = bytes[at];
            bytes[at] = (uint8_t)random_u64(&r);
            const char *path = write_new(names[f], bytes, size);
            cvol_volume *whole;
            if (cvol_volume_read(context, &whole, path, NULL) != CVOL_ERROR_LIMIT)
                check_refusal(path, NULL);
            else
                assert_true(stream_all(path, NULL) < 0); /* the limit is not for streams */
            cvol_volume_free(whole);
            bytes[at] = before;
        }
        cvol_context_set_limit_bytes(context, UINT64_C(64) << 30);
        free(bytes);
    }
    cvol_volume_free(volume);
}

static void test_wrong_sizes(void **state)
{
    (void)state;
    cvol_read_options options = {
        .size = sizeof(cvol_read_options), .dims = {3, 4, 5}, .type = CVOL_UINT8};
    check_refusal(in_folder("missing.raw"), &options);
    check_refusal(write_bytes("w.raw", counting, 59), &options);
    check_refusal(write_bytes("w.raw", counting, 61), &options);
    check_refusal(write_bytes("w.raw", counting, 60), NULL);
    options.spacing[2] = -1;
    check_refusal(in_folder("w.raw"), &options);
    options.dims[0] = SIZE_MAX;
    cvol_volume_stream *stream;
    assert_int_equal(cvol_volume_stream_open(context, &stream, in_folder("w.raw"), &options),
                     CVOL_ERROR_LIMIT);
    assert_null(stream);
    check_refusal(write_text("w.nhdr",
                             "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 2\nencoding: raw\n"
                             "data file: none.raw\n\n",
                             NULL, 0),
                  NULL);
}

/* Samples before the damage can be read, before and after the failure. */
static void test_cut_off(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(60, 50, 40, CVOL_INT16);
    cvol_volume *volume = make_volume(&grid, 8);
    check_ok(cvol_volume_write(context, volume, in_folder("c.nrrd")));
    size_t size, slice = slice_bytes(&grid);
    uint8_t *bytes = support_read(in_folder("c.nrrd"), &size), *out = malloc(slice);
    assert_non_null(out);
    const char *path = write_bytes("c.nrrd", bytes, size * 3 / 4);
    cvol_volume_stream *stream;
    check_ok(cvol_volume_stream_open(context, &stream, path, NULL));
    for (int round = 0; round < 3; round++) {
        check_ok(cvol_volume_stream_read(context, stream, out, 7, 1));
        assert_memory_equal(out, (uint8_t *)volume->data + 7 * slice, slice);
        assert_int_equal(cvol_volume_stream_read(context, stream, out, 39, 1), CVOL_ERROR_FORMAT);
        assert_non_null(strstr(cvol_context_message(context), "of the 240000 bytes"));
    }
    cvol_volume_stream_free(stream);
    free(bytes);
    free(out);
    cvol_volume_free(volume);
}

/* ---- writers ------------------------------------------------------------------------- */

/* Compressible samples of several steps of a sink. */
static cvol_volume *smooth_volume(const cvol_grid *grid)
{
    cvol_volume *volume;
    check_ok(cvol_volume_create(context, &volume, grid));
    size_t bytes = cvol_grid_bytes(grid);
    for (size_t i = 0; i < bytes; i++)
        ((uint8_t *)volume->data)[i] = (uint8_t)(i % 251 * (i / 4099) >> 3);
    return volume;
}

static void write_slabs(cvol_volume_writer *sink, const cvol_volume *volume, random_state *r)
{
    size_t slice = slice_bytes(&volume->grid), slices = volume->grid.dims[2], step;
    for (size_t z = 0; z < slices; z += step) {
        step = random_below(r, (uint32_t)(slices - z) + 1);
        if (random_below(r, 3))
            step = step < 3 ? step : 3;
        check_ok(
            cvol_volume_writer_write(context, sink, (uint8_t *)volume->data + z * slice, step));
    }
}

static void check_sink(const char *name, const char *data_name, const cvol_volume *volume,
                       random_state *r)
{
    const char *both[] = {name, data_name};
    uint8_t *expected[2] = {NULL, NULL};
    size_t sizes[2], size;
    check_ok(cvol_volume_write(context, volume, in_folder(name)));
    for (int i = 0; i < 2 && both[i]; i++) {
        expected[i] = support_read(in_folder(both[i]), &sizes[i]);
        assert_int_equal(remove(in_folder(both[i])), 0);
    }
    cvol_volume_writer *sink;
    check_ok(cvol_volume_writer_open(context, &sink, in_folder(name), &volume->grid));
    write_slabs(sink, volume, r);
    for (int i = 0; i < 2 && both[i]; i++)
        assert_int_equal(access(in_folder(both[i]), F_OK), -1);
    check_ok(cvol_volume_writer_commit(context, sink));
    for (int i = 0; i < 2 && both[i]; i++) {
        uint8_t *bytes = support_read(in_folder(both[i]), &size);
        assert_int_equal(size, sizes[i]);
        assert_memory_equal(bytes, expected[i], size);
        free(bytes);
        free(expected[i]);
    }
    cvol_volume *back = NULL;
    if (strcmp(name, "k.raw")) {
        back = read_ok(in_folder(name));
        same_samples(volume, back);
    }
    cvol_volume_free(back);
    assert_int_equal(support_folder_count(folder), data_name ? 2 : 1);
    for (int i = 0; i < 2 && both[i]; i++)
        remove(in_folder(both[i]));
}

static void test_sinks(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 5; seed++) {
        random_state r = {seed};
        cvol_grid grid = random_grid(&r, seed > 3);
        if (seed == 1) {
            grid = cvol_grid_make(160, 150, 70, CVOL_INT16);
            grid.spacing[1] = 0.5;
        }
        cvol_volume *volume = seed % 2 ? smooth_volume(&grid) : make_volume(&grid, seed);
        check_sink("k.nrrd", NULL, volume, &r);
        check_sink("k.nhdr", "k.raw", volume, &r);
        check_sink("k.mha", NULL, volume, &r);
        check_sink("k.mhd", "k.raw", volume, &r);
        check_sink("k.nii", NULL, volume, &r);
        check_sink("k.nii.gz", NULL, volume, &r);
        check_sink("k.raw", NULL, volume, &r);
        cvol_volume_free(volume);
    }
}

/* The size in a .mha is that of the bytes behind its header. */
static void test_packed_size(void **state)
{
    (void)state;
    cvol_grid grid = cvol_grid_make(30, 20, 10, CVOL_UINT8);
    cvol_volume *volume = smooth_volume(&grid);
    check_ok(cvol_volume_write(context, volume, in_folder("p.mha")));
    size_t size;
    uint8_t *bytes = support_read(in_folder("p.mha"), &size);
    const char *key = memmem(bytes, size, "CompressedDataSize = ", 21);
    const char *last = memmem(bytes, size, "ElementDataFile = LOCAL\n", 24);
    assert_true(key && last);
    size_t header_size = (size_t)(last + 24 - (const char *)bytes);
    assert_int_equal(strtoull(key + 21, NULL, 10), size - header_size);
    free(bytes);
    cvol_volume_free(volume);
    remove(in_folder("p.mha"));
}

/* Until all samples are written, and after any failure, the name keeps its old content. */
static void test_abandoned(void **state)
{
    (void)state;
    static const char *const sinks[] = {"o.nrrd", "o.nhdr",   "o.mha", "o.mhd",
                                        "o.nii",  "o.nii.gz", "o.raw"};
    cvol_grid grid = cvol_grid_make(8, 4, 3, CVOL_FLOAT32);
    cvol_volume *volume = make_volume(&grid, 3);
    uint8_t *samples = volume->data;
    cvol_volume_writer *sink;
    for (size_t f = 0; f < sizeof sinks / sizeof sinks[0]; f++) {
        const char *path = write_bytes(sinks[f], "before", 6);
        for (int way = 0; way < 3; way++) {
            check_ok(cvol_volume_writer_open(context, &sink, path, &grid));
            check_ok(cvol_volume_writer_write(context, sink, samples, 2));
            assert_int_equal(cvol_volume_writer_write(context, sink, samples, 2),
                             CVOL_ERROR_ARGUMENT);
            assert_non_null(strstr(cvol_context_message(context), "1 of its 3"));
            if (way == 0)
                cvol_volume_writer_abandon(sink);
            else if (way == 1) {
                assert_int_equal(cvol_volume_writer_commit(context, sink), CVOL_ERROR_ARGUMENT);
                assert_non_null(strstr(cvol_context_message(context), "2 of its 3"));
            } else { /* the sink itself is still good */
                check_ok(cvol_volume_writer_write(context, sink, samples + 256, 1));
                cvol_volume_writer_abandon(sink);
            }
            assert_int_equal(support_folder_count(folder), 1);
        }
        size_t size;
        uint8_t *bytes = support_read(path, &size);
        assert_true(size == 6 && !memcmp(bytes, "before", 6));
        free(bytes);
        remove(path);
    }
    cvol_volume_writer_abandon(NULL);
    assert_int_equal(cvol_volume_writer_open(context, &sink, in_folder("o.jpg"), &grid),
                     CVOL_ERROR_ARGUMENT);
    assert_null(sink);
    assert_int_equal(cvol_volume_writer_open(context, &sink, in_folder("none/o.mhd"), &grid),
                     CVOL_ERROR_IO);
    grid.dims[1] = 0;
    assert_int_equal(cvol_volume_writer_open(context, &sink, in_folder("o.mha"), &grid),
                     CVOL_ERROR_ARGUMENT);
    assert_int_equal(support_folder_count(folder), 0);
    cvol_volume_free(volume);
}

/* ---- beyond 4 GiB -------------------------------------------------------------------- */

/* A file of holes but for the bytes 1 .. 64 at two places; 0 if the disk cannot have it. */
static int write_sparse(const char *path, uint64_t size, uint64_t first, uint64_t second)
{
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    int made = fd >= 0 && !ftruncate(fd, (off_t)size) &&
               pwrite(fd, counting, 64, (off_t)first) == 64 &&
               pwrite(fd, counting, 64, (off_t)second) == 64;
    if (fd >= 0)
        close(fd);
    return made;
}

static void test_huge(void **state)
{
    (void)state;
    if (SIZE_MAX == UINT32_MAX) {
        print_message("skipped: a program of 32 bits refuses such sizes\n");
        return;
    }
    const size_t dims[3] = {2048, 1024, 2600}, slice = dims[0] * dims[1];
    const uint64_t size = (uint64_t)slice * dims[2], behind = (UINT64_C(1) << 32) + 5 * slice;
    assert_true(size > UINT32_MAX && behind % slice == 0);
    const char *path = in_folder("huge.raw");
    uint8_t *out = malloc(2 * slice);
    assert_non_null(out);
    if (!write_sparse(path, size, behind, size - 64)) {
        print_message("skipped: no file of %llu bytes\n", (unsigned long long)size);
        remove(path);
        free(out);
        return;
    }
    cvol_context_set_limit_bytes(context, 1 << 20); /* streams allocate nothing by it */
    cvol_read_options options = {
        .size = sizeof(cvol_read_options), .dims = {dims[0], dims[1], dims[2]}, .type = CVOL_UINT8};
    const char *text = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2048 1024 2600\n"
                       "encoding: raw\ndata file: huge.raw\n\n";
    const char *paths[] = {path, write_text("huge.nhdr", text, NULL, 0)};
    for (int i = 0; i < 2; i++) {
        cvol_volume *volume;
        cvol_volume_stream *stream;
        cvol_read_options *asked = i ? NULL : &options;
        assert_int_equal(cvol_volume_read(context, &volume, paths[i], asked), CVOL_ERROR_LIMIT);
        check_ok(cvol_volume_stream_open(context, &stream, paths[i], asked));
        assert_true(cvol_grid_samples(cvol_volume_stream_grid(stream)) == size);
        check_ok(cvol_volume_stream_read(context, stream, out, dims[2] - 2, 2));
        assert_memory_equal(out + 2 * slice - 64, counting, 64);
        assert_int_equal(out[2 * slice - 65], 0);
        check_ok(cvol_volume_stream_read(context, stream, out, (size_t)behind / slice - 1, 2));
        assert_memory_equal(out + slice, counting, 64);
        assert_int_equal(out[slice - 1], 0);
        check_ok(cvol_volume_stream_read(context, stream, out, 5, 1)); /* behind mod 2^32 */
        assert_int_equal(out[0], 0);
        cvol_volume_stream_free(stream);
    }
    cvol_context_set_limit_bytes(context, UINT64_C(64) << 30);
    remove(path);
    free(out);
}

/* The plan of a BigTIFF around a hole, as libtiff reads it: every page lies at its place. */
static void check_huge_tiff(const char *name, size_t slices, const cvol_series_options *series)
{
    const char *path = in_folder(name);
    cvol_grid grid = cvol_grid_make(2048, 1024, slices, CVOL_UINT8);
    const size_t slice = slice_bytes(&grid);
    const uint64_t bytes = (uint64_t)slice * slices * (uint64_t)series->channels;
    cvol_write_plan plan = {.series = series};
    cvol_volume_stream *stream;
    cvol_read_options options = cvol_read_options_defaults();
    uint8_t *out = malloc(slice);
    assert_non_null(out);
    for (int a = 0; a < 3; a++)
        grid.spacing[a] = 0.25 * (a + 1);
    check_ok(cvol_tiff_plan(context, &plan, &grid, path));
    const uint64_t last = plan.header.size + bytes - slice; /* of the last channel */
    const int made = write_sparse(path, plan.header.size + bytes, last, last + 64);
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    if (made) {
        assert_true(last > UINT32_MAX);
        assert_int_equal(pwrite(fd, plan.header.data, plan.header.size, 0), plan.header.size);
        assert_int_equal(
            pwrite(fd, plan.trailer.data, plan.trailer.size, (off_t)(plan.header.size + bytes)),
            plan.trailer.size);
        options.has_channel = series->channels > 1;
        options.channel = series->channels - 1;
        check_ok(cvol_volume_stream_open(context, &stream, path, &options));
        const cvol_grid *found = cvol_volume_stream_grid(stream);
        assert_int_equal(found->dims[2], slices);
        for (int a = 0; a < 3; a++)
            assert_true(found->spacing[a] == grid.spacing[a]);
        assert_int_equal(cvol_volume_stream_has_colours(stream), series->colours);
        check_ok(cvol_volume_stream_read(context, stream, out, slices - 1, 1));
        assert_memory_equal(out, counting, 64);
        assert_memory_equal(out + 64, counting, 64);
        assert_int_equal(out[128], 0);
        cvol_volume_stream_free(stream);
    } else
        print_message("skipped: no file of 5 GB\n");
    close(fd);
    remove(path);
    cvol_write_plan_free(&plan);
    free(out);
}

static void test_huge_tiff(void **state)
{
    (void)state;
    cvol_series_options series = cvol_series_options_defaults();
    if (!strstr(cvol_volume_readers(), ".tif") || SIZE_MAX == UINT32_MAX)
        return;
    check_huge_tiff("huge.tif", 2600, &series);
    series.channels = 2;
    check_huge_tiff("huge.ome.tif", 1300, &series);
    series.channels = 3;
    series.colours = 1;
    check_huge_tiff("colours.ome.tif", 800, &series);
}

int main(void)
{
    const struct CMUnitTest streams[] = {
        cmocka_unit_test(test_written),        cmocka_unit_test(test_foreign),
        cmocka_unit_test(test_no_such_slices), cmocka_unit_test(test_damage),
        cmocka_unit_test(test_wrong_sizes),    cmocka_unit_test(test_cut_off),
        cmocka_unit_test(test_huge),           cmocka_unit_test(test_huge_tiff),
    };
    const struct CMUnitTest sinks[] = {
        cmocka_unit_test(test_sinks),
        cmocka_unit_test(test_packed_size),
        cmocka_unit_test(test_abandoned),
    };
    int failed = cmocka_run_group_tests(streams, files_setup, files_teardown);
    failed += cmocka_run_group_tests(sinks, files_setup, files_teardown);
    return failed != 0;
}
