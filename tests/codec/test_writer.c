/* The writer of files: bricks one by one, more of them than fit into memory; failures leave no
 * file. */
#include "test.h"

#include <sys/stat.h>

#include "base/context.h"
#include "codec/brick/brick_index.h"
#include "codec/container/container.h"
#include "codec/container/layout.h"
#include "codec/container/writer.h"
#include "random.h"
#include "support.h"
#include "support_files.h"

enum { BRICKS = 90, MOST = 1 << 20 };

static uint8_t *noise; /* bricks' bytes are parts of it */

static int start(void **state)
{
    random_state r = {5};
    noise = malloc(2 * MOST);
    for (size_t i = 0; noise && i < 2 * MOST; i++)
        noise[i] = (uint8_t)random_u64(&r);
    return !noise || files_setup(state);
}

static int stop(void **state)
{
    free(noise);
    return files_teardown(state);
}

/* Some bricks have no bytes in some subbands. */
static void make_brick(cvol_span subbands[CVOL_SUBBANDS], size_t brick, size_t most)
{
    random_state r = {brick};
    for (int s = 0; s < CVOL_SUBBANDS; s++) {
        const size_t size = random_below(&r, 8) ? random_below(&r, (uint32_t)most) : 0;
        subbands[s] = (cvol_span){noise + random_below(&r, MOST), size};
    }
}

static cvol_file_writer *begin(const char *to, size_t most)
{
    cvol_file_writer *writer;
    assert_int_equal(cvol_file_writer_open(context, &writer, to, BRICKS, 16), CVOL_OK);
    for (size_t b = 0; b < BRICKS; b++) {
        cvol_span subbands[CVOL_SUBBANDS];
        make_brick(subbands, b, most);
        assert_int_equal(cvol_file_writer_add(context, writer, subbands), CVOL_OK);
    }
    return writer;
}

static cvol_header header_of(void)
{
    cvol_header header = {.grid = cvol_grid_make(64 * BRICKS, 64, 64, CVOL_UINT8),
                          .transform = CVOL_DCT,
                          .rank = 3,
                          .block = 16,
                          .step = 1};
    return header;
}

static uint64_t finish(cvol_file_writer *writer)
{
    const cvol_header header = header_of();
    cvol_token_tables *tables = cvol_token_tables_create();
    const cvol_file_front front = {.header = &header, .attributes = "{}", .tables = tables};
    uint64_t bytes = 0;
    assert_int_equal(cvol_file_writer_finish(context, writer, &front, &bytes), CVOL_OK);
    free(tables);
    return bytes;
}

/* Subbands and bricks of the file equal the given ones. */
static void expect_bricks(size_t most)
{
    size_t size;
    uint8_t *data = support_read(file_path, &size);
    cvol_file_layout layout;
    cvol_brick_index index = {0};
    int subband = 0;
    assert_int_equal(cvol_layout_walk(context, &layout, data, size, "f"), CVOL_OK);
    for (int i = 0; i < layout.section_count; i++) {
        const cvol_file_section *s = &layout.sections[i];
        const uint8_t *content = data + s->offset + CVOL_SECTION_HEADER_BYTES;
        const cvol_section section = {.length = s->length, .content = content};
        if (!strcmp(s->tag, "INDX"))
            assert_int_equal(cvol_brick_index_take(context, &index, &section, BRICKS, 16, "f"),
                             CVOL_OK);
        for (size_t b = 0; !strncmp(s->tag, "SHL", 3) && b < BRICKS; b++) {
            cvol_span wanted[CVOL_SUBBANDS];
            const cvol_span found = cvol_brick_index_brick(&index, subband, b, content);
            make_brick(wanted, b, most);
            assert_int_equal(found.size, wanted[subband].size);
            assert_int_equal(memcmp(found.data, wanted[subband].data, found.size), 0);
        }
        subband += !strncmp(s->tag, "SHL", 3);
    }
    assert_int_equal(subband, CVOL_SUBBANDS);
    cvol_brick_index_free(&index);
    free(data);
}

static void bricks_come_in_order(void **state)
{
    (void)state;
    /* 90 bricks of about 2 MiB: most of them do not stay in memory. */
    for (int i = 0; i < 2; i++) {
        const size_t most = i ? MOST : 100;
        cvol_file_writer *writer = begin(file_path, most);
        const uint64_t subbands = cvol_file_writer_subbands(writer);
        assert_true(!i || subbands > CVOL_SPOOLED_MAX);
        assert_true(support_folder_count(folder) <= 1); /* the output without its name */
        const uint64_t bytes = finish(writer);
        struct stat status;
        assert_int_equal(stat(file_path, &status), 0);
        assert_int_equal(bytes, status.st_size);
        assert_int_equal(support_folder_count(folder), 1);
        expect_bricks(most);
        /* Counted without a file. */
        writer = begin(NULL, most);
        assert_int_equal(cvol_file_writer_subbands(writer), subbands);
        assert_int_equal(finish(writer), bytes);
        assert_int_equal(remove(file_path), 0);
    }
}

static void failures_leave_no_file(void **state)
{
    (void)state;
    cvol_file_writer *writer = begin(file_path, MOST);
    cvol_file_writer_abandon(writer);
    assert_int_equal(support_folder_count(folder), 0);
    cvol_file_writer_abandon(NULL);
    /* Too few bricks, and too many. */
    cvol_span subbands[CVOL_SUBBANDS] = {{0}};
    const cvol_header header = header_of();
    const cvol_file_front front = {.header = &header};
    assert_int_equal(cvol_file_writer_open(context, &writer, file_path, 2, 16), CVOL_OK);
    assert_int_equal(cvol_file_writer_add(context, writer, subbands), CVOL_OK);
    assert_int_equal(cvol_file_writer_finish(context, writer, &front, NULL), CVOL_ERROR_ARGUMENT);
    assert_int_equal(support_folder_count(folder), 0);
    assert_int_equal(cvol_file_writer_open(context, &writer, file_path, 2, 16), CVOL_OK);
    assert_int_equal(cvol_file_writer_add_one(context, writer, CVOL_STREAM_MASK, 2, subbands[0]),
                     CVOL_ERROR_LIMIT);
    assert_string_equal(cvol_context_message(context), "brick 2 of 2 cannot be in a file");
    cvol_file_writer_abandon(writer);
    writer = begin(file_path, 10);
    assert_int_equal(cvol_file_writer_add(context, writer, subbands), CVOL_ERROR_LIMIT);
    cvol_file_writer_abandon(writer);
    assert_int_equal(support_folder_count(folder), 0);
}

static void full_devices_are_reported(void **state)
{
    (void)state;
    cvol_file_writer *writer;
    cvol_span subbands[CVOL_SUBBANDS] = {{noise, MOST}};
    const cvol_header header = header_of();
    cvol_token_tables *tables = cvol_token_tables_create();
    const cvol_file_front front = {.header = &header, .tables = tables};
    struct stat status;
    if (stat("/dev/full", &status) == 0) {
        assert_int_equal(cvol_file_writer_open(context, &writer, "/dev/full", 1, 16), CVOL_OK);
        assert_int_equal(cvol_file_writer_add(context, writer, subbands), CVOL_OK);
        assert_int_equal(cvol_file_writer_finish(context, writer, &front, NULL), CVOL_ERROR_IO);
        assert_string_equal(cvol_context_message(context), "/dev/full: No space left on device");
    } else {
        print_message("skipped: /dev/full\n");
    }
    free(tables);
    assert_int_equal(cvol_file_writer_open(context, &writer, "no/such/folder/a.cvol", 1, 16),
                     CVOL_ERROR_IO);
    assert_null(writer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bricks_come_in_order),
        cmocka_unit_test(failures_leave_no_file),
        cmocka_unit_test(full_devices_are_reported),
    };
    return cmocka_run_group_tests(tests, start, stop);
}
