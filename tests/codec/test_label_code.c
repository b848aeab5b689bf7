/* Labels: bricks round trip to the bit for any size, number and spacing of labels; regions are
 * cheap; damage does not crash. */
#include "test.h"

#include "codec/labels/label_code.h"
#include "random.h"

enum { SIDE = 64, MOST = SIDE * SIDE * SIDE };

typedef struct bench {
    cvol_label_coder *coder;
    cvol_label_brick brick;
    cvol_bytes bytes;
    uint32_t labels[MOST], decoded[MOST];
} bench;

static bench *bench_make(void)
{
    bench *b = calloc(1, sizeof *b);
    assert_non_null(b);
    b->coder = cvol_label_coder_create();
    assert_non_null(b->coder);
    return b;
}

static void bench_free(bench *b)
{
    cvol_label_coder_free(b->coder);
    cvol_bytes_free(&b->bytes);
    free(b);
}

static size_t count_of(const bench *b)
{
    return b->brick.size[0] * b->brick.size[1] * b->brick.size[2];
}

static void set_size(bench *b, size_t x, size_t y, size_t z)
{
    b->brick = (cvol_label_brick){.size = {x, y, z}, .most = UINT32_MAX, .labels = b->labels};
}

/* The brick encodes, and decodes to the same labels. */
static void check(bench *b, uint64_t seed)
{
    cvol_label_brick decoded = b->brick;
    decoded.labels = b->decoded;
    memset(b->decoded, 255, sizeof b->decoded);
    assert_int_equal(cvol_label_encode(b->coder, &b->bytes, &b->brick), CVOL_OK);
    assert_int_equal(
        cvol_label_decode(b->coder, &decoded, (cvol_span){b->bytes.data, b->bytes.size}), CVOL_OK);
    for (size_t i = 0; i < count_of(b); i++)
        if (b->labels[i] != b->decoded[i])
            fail_msg("seed %llu: label %zu of %zu x %zu x %zu is %u, decodes to %u",
                     (unsigned long long)seed, i, b->brick.size[0], b->brick.size[1],
                     b->brick.size[2], b->labels[i], b->decoded[i]);
}

static size_t random_side(random_state *r)
{
    const uint32_t kind = random_below(r, 4);
    return kind == 0 ? 1 : kind == 1 ? SIDE : 1 + random_below(r, kind == 2 ? 20 : SIDE);
}

/* Ids up to `most`: dense, sparse and huge, or close to the largest. */
static uint32_t random_id(random_state *r, uint32_t kind, uint32_t most)
{
    return kind == 0   ? random_below(r, most < 255 ? most + 1 : 256)
           : kind == 1 ? (uint32_t)(random_u64(r) % ((uint64_t)most + 1))
                       : most - random_below(r, most < 9 ? most + 1 : 10);
}

/* Regions of the nearest of some seeds, of the seed that was drawn for a block, or noise. */
static void fill(bench *b, random_state *r)
{
    enum { SEEDS_MAX = 300 };
    int place[SEEDS_MAX][3];
    uint32_t id[SEEDS_MAX];
    const uint32_t kind = random_below(r, 4), ids = random_below(r, 3);
    const uint32_t seeds = 1 + random_below(r, random_below(r, 2) ? 3 : kind ? SEEDS_MAX : 30);
    const size_t *size = b->brick.size;
    b->brick.most = random_below(r, 2) ? UINT32_MAX : 1 + random_below(r, 1 << 20);
    for (uint32_t i = 0; i < seeds; i++) {
        for (int a = 0; a < 3; a++)
            place[i][a] = (int)random_below(r, (uint32_t)size[a]);
        id[i] = random_id(r, ids, b->brick.most);
    }
    uint32_t *to = b->labels, of_block = 0;
    for (size_t z = 0; z < size[2]; z++)
        for (size_t y = 0; y < size[1]; y++)
            for (size_t x = 0; x < size[0]; x++, to++) {
                const int at[3] = {(int)x, (int)y, (int)z};
                uint32_t best = 0;
                int least = INT32_MAX;
                if (kind == 1 && x % 5 == 0)
                    of_block = random_below(r, seeds);
                for (uint32_t i = 0; i < seeds && kind == 0; i++) {
                    int squares = 0;
                    for (int a = 0; a < 3; a++)
                        squares += (at[a] - place[i][a]) * (at[a] - place[i][a]);
                    best = squares < least ? i : best;
                    least = squares < least ? squares : least;
                }
                *to = id[kind == 0                  ? best
                         : kind == 1                ? of_block
                         : kind == 2                ? random_below(r, seeds)
                         : random_below(r, 40) == 0 ? random_below(r, seeds)
                                                    : 0];
            }
}

static void test_round_trip(void **state)
{
    (void)state;
    bench *b = bench_make();
    for (uint64_t seed = 1; seed <= 120; seed++) {
        random_state r = {seed};
        set_size(b, random_side(&r), random_side(&r), random_side(&r));
        fill(b, &r);
        check(b, seed);
    }
    bench_free(b);
}

static void test_shapes(void **state)
{
    (void)state;
    static const size_t shapes[][3] = {{1, 1, 1},   {64, 1, 1}, {1, 64, 1},      {1, 1, 64},
                                       {1, 17, 33}, {2, 1, 64}, {63, 64, 65 - 1}};
    bench *b = bench_make();
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++)
        for (uint64_t seed = 1; seed <= 6; seed++) {
            random_state r = {seed};
            set_size(b, shapes[s][0], shapes[s][1], shapes[s][2]);
            fill(b, &r);
            check(b, seed);
        }
    bench_free(b);
}

/* A ball within another label takes less than 0.6 bits for each sample of its surface. */
static void test_regions_are_cheap(void **state)
{
    (void)state;
    bench *b = bench_make();
    set_size(b, SIDE, SIDE, SIDE);
    size_t surface = 0;
    for (size_t i = 0; i < MOST; i++) {
        const double x = (double)(i % SIDE) - 31, y = (double)(i / SIDE % SIDE) - 30,
                     z = (double)(i / SIDE / SIDE) - 33;
        const double radius = sqrt(x * x + y * y + z * z);
        b->labels[i] = radius < 25 ? 4000000007u : 70001;
        surface += radius >= 24 && radius < 25;
    }
    check(b, 0);
    if (getenv("CVOL_TEST_VERBOSE"))
        printf("ball: %zu bytes for %zu samples of surface\n", b->bytes.size, surface);
    assert_true(8 * (double)b->bytes.size < 0.6 * (double)surface);

    for (size_t i = 0; i < MOST; i++)
        b->labels[i] = 12345678;
    check(b, 0);
    assert_true(b->bytes.size < 16);
    bench_free(b);
}

/* A brick with the most labels codes; one more is refused. */
static void test_many_labels(void **state)
{
    (void)state;
    bench *b = bench_make();
    for (int more = 0; more < 2; more++) {
        set_size(b, 64, 64, 2);
        for (uint32_t i = 0; i < 64 * 64 * 2; i++)
            b->labels[i] = 977 * (i % (uint32_t)(CVOL_LABELS_MAX + more));
        if (more)
            assert_int_equal(cvol_label_encode(b->coder, &b->bytes, &b->brick), CVOL_ERROR_TARGET);
        else
            check(b, 0);
    }
    bench_free(b);
}

/* Damaged and cut bricks fail, or decode to labels within the range. */
static void test_damage(void **state)
{
    (void)state;
    bench *b = bench_make();
    size_t refused = 0, tried = 0;
    for (uint64_t seed = 1; seed <= 40; seed++) {
        random_state r = {seed};
        set_size(b, 1 + random_below(&r, 24), 1 + random_below(&r, 24), 1 + random_below(&r, 24));
        fill(b, &r);
        assert_int_equal(cvol_label_encode(b->coder, &b->bytes, &b->brick), CVOL_OK);
        cvol_label_brick decoded = b->brick;
        decoded.labels = b->decoded;
        for (int i = 0; i < 20 && b->bytes.size; i++, tried++) {
            uint8_t *copy = malloc(b->bytes.size);
            assert_non_null(copy);
            memcpy(copy, b->bytes.data, b->bytes.size);
            size_t size = b->bytes.size;
            if (i % 2)
                size = random_below(&r, (uint32_t)size);
            else
                copy[random_below(&r, (uint32_t)size)] ^= (uint8_t)(1u << random_below(&r, 8));
            const int code = cvol_label_decode(b->coder, &decoded, (cvol_span){copy, size});
            free(copy);
            refused += code != CVOL_OK;
            assert_true(code == CVOL_OK || code == CVOL_ERROR_CORRUPT);
            for (size_t k = 0; !code && k < count_of(b); k++)
                assert_true(b->decoded[k] <= b->brick.most);
        }
    }
    assert_true(refused > tried / 4);
    bench_free(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip), cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_regions_are_cheap), cmocka_unit_test(test_many_labels),
        cmocka_unit_test(test_damage)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
