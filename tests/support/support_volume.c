/* Common code of tests of volumes: a context and a folder, files in the folder, small volumes,
 * checks of read volumes, and NIfTI headers. */
#include "test.h"

#include "support_volume.h"

#include <zlib.h>

#include "base/byte_order.h"
#include "base/memory.h"
#include "random.h"
#include "support.h"

#define EIGHT(n) n + 1, n + 2, n + 3, n + 4, n + 5, n + 6, n + 7, (n + 8) % 256
#define SIXTY_FOUR(n)                                                                   \
    EIGHT(n), EIGHT(n + 8), EIGHT(n + 16), EIGHT(n + 24), EIGHT(n + 32), EIGHT(n + 40), \
        EIGHT(n + 48), EIGHT(n + 56)

const uint8_t counting[256] = {SIXTY_FOUR(0), SIXTY_FOUR(64), SIXTY_FOUR(128), SIXTY_FOUR(192)};

/* ---- files in the folder ------------------------------------------------------------- */

const char *in_folder(const char *name)
{
    static char paths[16][512];
    static size_t next;
    char *path = paths[next++ % 16];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

const char *write_bytes(const char *name, const void *data, size_t size)
{
    const char *path = in_folder(name);
    support_write(path, data, size);
    return path;
}

const char *write_text(const char *name, const char *text, const void *data, size_t size)
{
    size_t length = strlen(text);
    uint8_t *bytes = malloc(length + size + 1);
    assert_non_null(bytes);
    memcpy(bytes, text, length);
    if (size)
        memcpy(bytes + length, data, size);
    const char *path = write_bytes(name, bytes, length + size);
    free(bytes);
    return path;
}

size_t gzip(uint8_t *out, size_t room, const void *data, size_t size, int window_bits)
{
    z_stream stream;
    memset(&stream, 0, sizeof stream);
    assert_int_equal(deflateInit2(&stream, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY),
                     Z_OK);
    stream.next_in = (z_const Bytef *)data;
    stream.avail_in = (uInt)size;
    stream.next_out = out;
    stream.avail_out = (uInt)room;
    assert_int_equal(deflate(&stream, Z_FINISH), Z_STREAM_END);
    deflateEnd(&stream);
    return room - stream.avail_out;
}

/* ---- reading ------------------------------------------------------------------------- */

cvol_volume *read_ok(const char *path)
{
    cvol_volume *volume = NULL;
    check_ok(cvol_volume_read(context, &volume, path, NULL));
    assert_non_null(volume);
    assert_int_equal((uintptr_t)volume->data % CVOL_ALLOCATED_ALIGNMENT, 0);
    return volume;
}

void read_fails_with(const char *path, const cvol_read_options *options, int code, const char *word,
                     const char *other)
{
    cvol_volume *volume = (cvol_volume *)&volume;
    int got = cvol_volume_read(context, &volume, path, options);
    const char *message = cvol_context_message(context);
    if (got != code || !strstr(message, word) || !strstr(message, other))
        print_error("code %d (not %d), '%s' lacks '%s' or '%s'\n", got, code, message, word, other);
    assert_int_equal(got, code);
    assert_null(volume);
    assert_non_null(strstr(message, word));
    assert_non_null(strstr(message, other));
    assert_int_equal(strncmp(message, path, strlen(path)), 0);
    assert_null(strchr(message, '\n'));
}

void read_fails(const char *path, int code, const char *word, const char *other)
{
    read_fails_with(path, NULL, code, word, other);
}

void read_fails_large(const char *path, int code, const char *word)
{
    if (SIZE_MAX > UINT32_MAX)
        read_fails(path, code, word, "");
    else
        read_fails(path, CVOL_ERROR_LIMIT, "more than the limit of 4294967295 bytes", "");
}

/* ---- small volumes ------------------------------------------------------------------- */

static void fill_random(cvol_volume *volume, uint64_t seed)
{
    random_state r = {seed};
    size_t samples = cvol_grid_samples(&volume->grid);
    for (size_t i = 0; i < samples; i++) {
        uint64_t bits = random_u64(&r);
        if (volume->grid.type == CVOL_FLOAT32)
            ((float *)volume->data)[i] = (float)random_signed(&r);
        else if (volume->grid.type == CVOL_FLOAT64)
            ((double *)volume->data)[i] = random_signed(&r);
        else {
            size_t size = cvol_type_size(volume->grid.type);
            memcpy((uint8_t *)volume->data + i * size, &bits, size);
        }
    }
}

cvol_grid odd_grid(cvol_type type, int mirrored)
{
    cvol_grid grid = cvol_grid_make(5, 4, 3, type);
    const double axes[3][3] = {{2, 3, 6}, {-6, -2, 3}, {3, -6, 2}}; /* orthogonal, of length 7 */
    const double spacing[3] = {0.1, 1.75, 2.0 / 3}, origin[3] = {-12.5, 1.0 / 3, 4000.25};
    for (int a = 0; a < 3; a++) {
        grid.spacing[a] = spacing[a];
        grid.origin[a] = origin[a];
        for (int i = 0; i < 3; i++)
            grid.direction[a][i] = axes[a][i] / (a == 2 && mirrored ? -7 : 7);
    }
    grid.space = CVOL_SPACE_RAS;
    memcpy(grid.unit, "mm", 3);
    return grid;
}

cvol_volume *make_volume(const cvol_grid *grid, uint64_t seed)
{
    cvol_volume *volume;
    check_ok(cvol_volume_create(context, &volume, grid));
    fill_random(volume, seed);
    return volume;
}

void near(double a, double b, double relative)
{
    if (!(fabs(a - b) <= relative * fmax(1, fabs(b))))
        print_error("%.17g is not near %.17g\n", a, b);
    assert_true(fabs(a - b) <= relative * fmax(1, fabs(b)));
}

void same_samples(const cvol_volume *a, const cvol_volume *b)
{
    assert_int_equal(a->grid.type, b->grid.type);
    for (int i = 0; i < 3; i++)
        assert_int_equal(a->grid.dims[i], b->grid.dims[i]);
    assert_memory_equal(a->data, b->data, cvol_grid_bytes(&a->grid));
}

void same_place(const cvol_grid *a, const cvol_grid *b, double relative, int turned)
{
    for (int i = 0; i < 3; i++) {
        double sign = turned && i < 2 ? -1 : 1;
        near(b->spacing[i], a->spacing[i], relative);
        near(sign * b->origin[i], a->origin[i], relative);
        for (int axis = 0; axis < 3; axis++)
            near(sign * b->direction[axis][i], a->direction[axis][i], relative);
    }
}

/* ---- NIfTI headers ------------------------------------------------------------------- */

/* Little-endian, or big-endian if the header is swapped. */
static void set(header *h, size_t at, const void *value, size_t width)
{
    const int is_turned = (h->swapped != 0) != cvol_machine_is_big_endian();
    for (size_t i = 0; i < width; i++)
        h->bytes[at + i] = ((const uint8_t *)value)[is_turned ? width - 1 - i : i];
}

void set16(header *h, size_t at, int value)
{
    int16_t v = (int16_t)value;
    set(h, at, &v, sizeof v);
}

void set32(header *h, size_t at, int32_t value)
{
    set(h, at, &value, sizeof value);
}

void set64(header *h, size_t at, int64_t value)
{
    set(h, at, &value, sizeof value);
}

void set_float(header *h, size_t at, float value)
{
    set(h, at, &value, sizeof value);
}

void set_double(header *h, size_t at, double value)
{
    set(h, at, &value, sizeof value);
}

void set_dims(header *h, int64_t count, int64_t x, int64_t y, int64_t z, int64_t t)
{
    const int64_t dims[8] = {count, x, y, z, t, 1, 1, 1};
    for (size_t i = 0; i < 8; i++)
        if (h->version == 1)
            set16(h, 40 + 2 * i, (int)dims[i]);
        else
            set64(h, 16 + 8 * i, dims[i]);
}

header nifti1(int swapped)
{
    header h = {.version = 1, .swapped = swapped};
    set32(&h, 0, 348);
    set_dims(&h, 3, 2, 3, 2, 1);
    set16(&h, 70, 2);
    set16(&h, 72, 8);
    for (size_t i = 0; i < 4; i++)
        set_float(&h, 76 + 4 * i, (float)i + 1);
    set_float(&h, 108, 352);
    memcpy(h.bytes + 344, "n+1", 4);
    return h;
}

header nifti2(int swapped)
{
    header h = {.version = 2, .swapped = swapped};
    set32(&h, 0, 540);
    memcpy(h.bytes + 4, "n+2\0\r\n\032\n", 8);
    set_dims(&h, 3, 2, 3, 2, 1);
    set16(&h, 12, 2);
    set16(&h, 14, 8);
    for (size_t i = 0; i < 4; i++)
        set_double(&h, 104 + 8 * i, (double)i + 1);
    set64(&h, 168, 544);
    return h;
}
