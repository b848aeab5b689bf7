/* Section TABL: the differences of a file's codes from the built-in ones, in units of
 * CVOL_CODE_STEP, by the adaptive range coder. */
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "codec/entropy/range_coder.h"
#include "codec/entropy/token_tables.h"

enum { UNARY = 24, CLASSES = 4 };

/* Contexts of the coder. */
typedef struct section_model {
    cvol_probability row[2];                 /* the row has changes; context: the row before has
                                                changes */
    cvol_probability zero[CLASSES], sign[2]; /* of a change; context: the code before */
    cvol_probability unary[UNARY];           /* of a change's magnitude */
} section_model;

static void model_start(section_model *model)
{
    cvol_probability *all = (cvol_probability *)model;
    for (size_t i = 0; i < sizeof *model / sizeof *all; i++)
        all[i] = (cvol_probability){1 << 15, 1 << 15};
}

static int class_of(int t)
{
    return t < CLASSES ? t : CLASSES - 1;
}

static int change_of(const cvol_token_tables *tables, int r, int t)
{
    return (tables->codes[r][t] - cvol_token_defaults[r][t]) / CVOL_CODE_STEP;
}

static void put_row(cvol_range_encoder *out, section_model *model, const cvol_token_tables *tables,
                    int r)
{
    int before = 0;
    for (int t = 0; t < CVOL_TOKEN_CODES; t++) {
        const int change = change_of(tables, r, t), magnitude = abs(change);
        cvol_encode_bit(out, &model->zero[class_of(t)], change != 0);
        if (!change)
            continue;
        cvol_encode_bit(out, &model->sign[before], change < 0);
        before = change < 0;
        for (int n = 1; n <= magnitude; n++)
            cvol_encode_bit(out, &model->unary[n <= UNARY ? n - 1 : UNARY - 1], n < magnitude);
    }
}

int cvol_token_tables_put(cvol_context *context, cvol_bytes *out, const cvol_token_tables *tables)
{
    cvol_range_encoder encoder = {0};
    section_model model;
    int before = 0;
    model_start(&model);
    cvol_range_encoder_start(&encoder);
    for (int r = 0; r < CVOL_ROWS; r++) {
        const int differs = memcmp(tables->codes[r], cvol_token_defaults[r], CVOL_TOKEN_CODES) != 0;
        cvol_encode_bit(&encoder, &model.row[before], differs);
        if (differs)
            put_row(&encoder, &model, tables, r);
        before = differs;
    }
    const int done = cvol_range_encoder_finish(&encoder, out);
    cvol_range_encoder_free(&encoder);
    return done ? CVOL_OK : cvol_fail_memory(context, CVOL_ROWS, "the coder's tables");
}

/* Returns 0 if a code leaves 0 .. 255. */
static int take_row(cvol_range_decoder *in, section_model *model, uint8_t codes[CVOL_TOKEN_CODES])
{
    int before = 0;
    for (int t = 0; t < CVOL_TOKEN_CODES; t++) {
        if (!cvol_decode_bit(in, &model->zero[class_of(t)]))
            continue;
        before = cvol_decode_bit(in, &model->sign[before]);
        int magnitude = 1;
        while (magnitude < 256 &&
               cvol_decode_bit(in, &model->unary[magnitude <= UNARY ? magnitude - 1 : UNARY - 1]))
            magnitude++;
        const int code = codes[t] + (before ? -magnitude : magnitude) * CVOL_CODE_STEP;
        if (code < 0 || code > 255)
            return 0;
        codes[t] = (uint8_t)code;
    }
    return 1;
}

int cvol_token_tables_take(cvol_context *context, cvol_token_tables *tables, cvol_cursor *content,
                           const char *name)
{
    const size_t size = cvol_cursor_left(content);
    const uint8_t *data = cvol_cursor_take(content, size);
    cvol_range_decoder decoder;
    section_model model;
    int before = 0, valid = 1;
    model_start(&model);
    cvol_range_decoder_start(&decoder, data, size);
    memcpy(tables->codes, cvol_token_defaults, sizeof tables->codes);
    for (int r = 0; r < CVOL_ROWS && valid; r++) {
        before = cvol_decode_bit(&decoder, &model.row[before]);
        if (before)
            valid = take_row(&decoder, &model, tables->codes[r]);
    }
    if (!valid || cvol_range_decoder_overrun(&decoder))
        return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section TABL does not decode", name);
    cvol_token_tables_commit(tables);
    return CVOL_OK;
}
