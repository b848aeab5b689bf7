/* The codec's tables are part of the format: no number of src/codec/tables may change. */
#include "test.h"

#include "base/byte_order.h"
#include "base/bytes.h"
#include "codec/entropy/token_tables.h"
#include "codec/mask/mask_predict.h"
#include "codec/neural/neural_model.h"

static void token_codes(void **state)
{
    (void)state;
    assert_int_equal(sizeof cvol_token_defaults, CVOL_ROWS * CVOL_TOKEN_CODES);
    assert_int_equal(cvol_crc32c(cvol_token_defaults, sizeof cvol_token_defaults), 0x8895f48d);
}

/* All 256 probabilities, as the first frequency of a row, 2^-2 of them; `ctest -R tables` compares
 * the numbers themselves with the formula. */
static void token_probabilities(void **state)
{
    (void)state;
    cvol_token_tables *tables = cvol_token_tables_create();
    assert_non_null(tables);
    for (int code = 0; code < 256; code++) {
        const double p = floor(65536 / (1 + exp((127.5 - code) / 12.75)) + 0.5);
        tables->codes[0][0] = (uint8_t)code;
        cvol_token_tables_commit(tables);
        const int frequency = (int)floor(p / 4 + 0.5), most = (1 << CVOL_TOKEN_SCALE) - 15;
        assert_int_equal(tables->rows[0].bounds[8], frequency < 1      ? 1
                                                    : frequency > most ? most
                                                                       : frequency);
    }
    free(tables);
}

/* The CRC of integers of `size` bytes as little-endian bytes, after those of `crc`. */
static uint32_t add(uint32_t crc, const void *integers, size_t bytes, size_t size)
{
    uint8_t reversed[4];
    if (!cvol_machine_is_big_endian())
        return cvol_crc32c_more(crc, integers, bytes);
    for (size_t i = 0; i < bytes; i += size) {
        for (size_t k = 0; k < size; k++)
            reversed[k] = ((const uint8_t *)integers)[i + size - 1 - k];
        crc = cvol_crc32c_more(crc, reversed, size);
    }
    return crc;
}

/* Member by member: the struct ends with padding. */
static void mask_network(void **state)
{
    (void)state;
    const cvol_mask_network *n = &cvol_mask_trained;
    uint32_t crc = add(0, n->weights, sizeof n->weights, 2);
    crc = add(crc, n->biases, sizeof n->biases, 2);
    crc = add(crc, n->outs, sizeof n->outs, 2);
    assert_int_equal(add(crc, &n->out_bias, sizeof n->out_bias, 4), 0x35bd7ee4);
}

static uint32_t crc_of(const cvol_neural_network *n)
{
    uint32_t crc = add(0, n->first, sizeof n->first, 2);
    crc = add(crc, n->first_bias, sizeof n->first_bias, 4);
    crc = add(crc, n->second, sizeof n->second, 2);
    crc = add(crc, n->second_bias, sizeof n->second_bias, 4);
    crc = add(crc, n->third, sizeof n->third, 2);
    return add(crc, n->third_bias, sizeof n->third_bias, 4);
}

static void neural_networks(void **state)
{
    (void)state;
    assert_int_equal(sizeof(cvol_neural_network), 26752); /* no padding */
    assert_int_equal(crc_of(&cvol_neural_magnitudes), 0x81b1f791);
    assert_int_equal(crc_of(&cvol_neural_signs), 0x9f006a3c);
}

static void neural_rows(void **state)
{
    (void)state;
    assert_int_equal(cvol_crc32c(cvol_neural_rows, sizeof cvol_neural_rows), 0x7b3af0ef);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(token_codes),  cmocka_unit_test(token_probabilities),
        cmocka_unit_test(mask_network), cmocka_unit_test(neural_networks),
        cmocka_unit_test(neural_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
