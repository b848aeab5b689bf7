/* Creating renderers: the sources that each engine draws, and refusals. */
#include "test.h"

#include "cvol/codec.h"
#include "cvol/render.h"
#include "support.h"
#include "support_context.h"

static uint8_t samples[8] __attribute__((aligned(64))) = {1, 2, 3, 4, 5, 6, 7, 8};

static void refuse(int engine, const cvol_source *source, const char *part)
{
    cvol_renderer *renderer = (cvol_renderer *)samples;
    assert_int_equal(cvol_renderer_create(context, &renderer, (cvol_engine)engine, source),
                     CVOL_ERROR_ARGUMENT);
    assert_null(renderer);
    if (!strstr(cvol_context_message(context), part))
        fail_msg("\"%s\" lacks \"%s\"", cvol_context_message(context), part);
}

static void test_refusals(void **state)
{
    (void)state;
    const cvol_volume volume = {cvol_grid_make(2, 2, 2, CVOL_UINT8), samples};
    const cvol_source dense = {.size = sizeof dense, .volume = &volume},
                      baked = {.size = sizeof baked, .baked_path = "x.cvol"},
                      both = {.size = sizeof both, .volume = &volume, .baked_path = "x.cvol"},
                      none = {.size = sizeof none}, unsized = {.volume = &volume};
    refuse(0, &dense, "0 is not an engine");
    refuse(6, &dense, "6 is not an engine");
    refuse(CVOL_ENGINE_RAY, &unsized, "cvol_source: its size is 0");
    refuse(CVOL_ENGINE_RAY, &none, "0 are given");
    refuse(CVOL_ENGINE_TRANSFORM, &both, "2 are given");
    refuse(CVOL_ENGINE_SHEET, &dense, "engine sheet draws no dense volume");
    refuse(CVOL_ENGINE_RAY, &baked, "engine ray draws no baked file");
    refuse(CVOL_ENGINE_SPLAT, &baked, "engine splat draws no baked file");
}

/* Every engine that draws dense volumes and arrays lists these sources. */
static void test_sources(void **state)
{
    (void)state;
    const cvol_volume volume = {cvol_grid_make(2, 2, 2, CVOL_UINT8), samples};
    cvol_array *array;
    const cvol_compress_options options = cvol_compress_options_defaults();
    assert_int_equal(cvol_compress(context, &array, NULL, samples, &volume.grid, &options),
                     CVOL_OK);
    for (int engine = CVOL_ENGINE_SHEET; engine <= CVOL_ENGINE_FOURIER; engine++)
        for (int dense = 0; dense < 2; dense++) {
            if ((engine == CVOL_ENGINE_SHEET && dense) || (engine == CVOL_ENGINE_RAY && !dense))
                continue;
            cvol_renderer *renderer;
            const cvol_source source = {.size = sizeof source,
                                        .array = dense ? NULL : array,
                                        .volume = dense ? &volume : NULL};
            assert_int_equal(cvol_renderer_create(context, &renderer, (cvol_engine)engine, &source),
                             CVOL_OK);
            cvol_renderer_free(renderer);
        }
    cvol_array_free(array);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_refusals),
                                       cmocka_unit_test(test_sources)};
    return cmocka_run_group_tests(tests, context_setup, context_teardown);
}
