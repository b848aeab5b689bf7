/* The policy of the sheet engine as a table of cases: the effect of each input, and no other
 * effect. */
#include "test.h"

#include "render/sheet/frame/kernel_table.h"
#include "render/sheet/frame/policy.h"
#include "support.h"

/* An opaque function, unlit, pixels as large as samples, on a processor with AVX-512. */
static cvol_policy_case usual(void)
{
    return (cvol_policy_case){.mode = CVOL_MODE_COMPOSITE,
                              .asked = CVOL_RAY_ORDER_AUTO,
                              .pixel = 1,
                              .rays = 1,
                              .traits = {0, 0.05},
                              .fits_lit_int16 = 1,
                              .has_range = 1,
                              .cpu = CVOL_CPU_AVX512};
}

#define IMAGE CVOL_RAY_ORDER_IMAGE
#define OBJECT CVOL_RAY_ORDER_OBJECT
#define FLOATS CVOL_SAMPLES_FLOAT
#define INT16 CVOL_SAMPLES_INT16

typedef struct row {
    const char *name;
    void (*change)(cvol_policy_case *in);
    cvol_policy expected;
} row;

#define CHANGE(name, ...)                  \
    static void name(cvol_policy_case *in) \
    {                                      \
        __VA_ARGS__;                       \
    }

CHANGE(nothing, (void)in)
CHANGE(asks_object, in->asked = OBJECT)
CHANGE(wide_pixels, in->pixel = 1.5; in->traits.noise = 0.1)
CHANGE(noisy, in->traits.noise = 0.1)
CHANGE(noisy_object, in->traits.noise = 0.1; in->asked = OBJECT)
CHANGE(noisy_but_step, in->traits.noise = 0.1; in->step = 0.5)
CHANGE(translucent, in->traits.is_translucent = 1)
CHANGE(translucent_exact, in->traits.is_translucent = 1; in->traits.noise = 0)
CHANGE(translucent_lit, in->traits.is_translucent = in->lit = 1)
CHANGE(translucent_wide, in->traits.is_translucent = 1; in->pixel = 1.5)
CHANGE(translucent_step, in->traits.is_translucent = 1; in->step = 0.5)
CHANGE(exact, in->traits.noise = 0)
CHANGE(lit, in->lit = 1)
CHANGE(lit_avx2, in->lit = 1; in->cpu = CVOL_CPU_AVX2)
CHANGE(lit_thin, in->lit = in->is_thin = 1)
CHANGE(lit_depth, in->lit = in->has_depth = 1)
CHANGE(lit_exact, in->lit = 1; in->fits_lit_int16 = 0)
CHANGE(lit_oblique, in->lit = in->is_oblique = 1)
CHANGE(lit_zoomed_object, in->lit = 1; in->pixel = 0.5; in->asked = OBJECT)
CHANGE(lit_zoomed_image, in->lit = 1; in->pixel = 0.5)
CHANGE(lit_zoomed_translucent, in->lit = 1; in->pixel = 0.5; in->traits.is_translucent = 1)
CHANGE(depth, in->has_depth = 1)
CHANGE(counted, in->counts = 1)
CHANGE(wide_footprint, in->is_wide = 1)
CHANGE(levels, in->level = 1)
CHANGE(perspective, in->perspective = 1)
CHANGE(oversampled, in->rays = 2)
CHANGE(voids, in->masked = CVOL_SHEET_SOME_VOID)
CHANGE(background, in->masked = CVOL_SHEET_SOME_BACKGROUND)
CHANGE(constant, in->has_range = 0)
CHANGE(avx2, in->cpu = CVOL_CPU_AVX2)
CHANGE(surface, in->mode = CVOL_MODE_ISO; in->lit = 1)
CHANGE(mip, in->mode = CVOL_MODE_MIP)
CHANGE(mip_avx2, in->mode = CVOL_MODE_MIP; in->cpu = CVOL_CPU_AVX2)
CHANGE(mip_level, in->mode = CVOL_MODE_MIP; in->level = 1)
CHANGE(xray, in->mode = CVOL_MODE_XRAY)
CHANGE(xray_asked, in->mode = CVOL_MODE_XRAY; in->asked = OBJECT)

#define COARSE CVOL_INTERVALS_COARSE
#define IF_TRANSLUCENT CVOL_INTERVALS_COARSE_IF_TRANSLUCENT

/* order, ray spacing, coarsest, intervals, gradients, samples */
static const row rows[] = {
    {"nothing", nothing, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"asks for object order", asks_object, {OBJECT, 1, 0.7, IF_TRANSLUCENT, 0, INT16}},
    {"wide pixels", wide_pixels, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"noisy", noisy, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"noisy, object order", noisy_object, {OBJECT, 1, 0.7, COARSE, 0, INT16}},
    {"noisy, with a step", noisy_but_step, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"translucent", translucent, {OBJECT, 1.5, 0.7, IF_TRANSLUCENT, 0, INT16}},
    {"translucent, exact", translucent_exact, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"translucent, lit", translucent_lit, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"translucent, wide pixels", translucent_wide, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"translucent, with a step", translucent_step, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"exact", exact, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"lit", lit, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"lit, AVX2", lit_avx2, {IMAGE, 1, 0.7, 0, 0, FLOATS}},
    {"lit, one sample thick", lit_thin, {OBJECT, 1, 0.7, 0, 0, FLOATS}},
    {"lit, depth", lit_depth, {OBJECT, 1, 0.7, 0, 0, FLOATS}},
    {"lit, too exact for int16", lit_exact, {IMAGE, 1, 0.7, 0, 0, FLOATS}},
    {"lit, oblique", lit_oblique, {OBJECT, 1, 0.7, 0, 0, FLOATS}},
    {"lit, zoomed, object order", lit_zoomed_object, {OBJECT, 1, 0.7, 0, 1, FLOATS}},
    {"lit, zoomed", lit_zoomed_image, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"lit, zoomed, translucent", lit_zoomed_translucent, {IMAGE, 1, 0.7, 0, 1, INT16}},
    {"depth", depth, {IMAGE, 1, 0.7, 0, 0, FLOATS}},
    {"counted", counted, {IMAGE, 1, 0.7, 0, 0, FLOATS}},
    {"wide footprint", wide_footprint, {OBJECT, 1, 0.7, IF_TRANSLUCENT, 0, FLOATS}},
    {"level", levels, {OBJECT, 1, 0.7, IF_TRANSLUCENT, 0, INT16}},
    {"perspective", perspective, {OBJECT, 1, 0.7, IF_TRANSLUCENT, 0, FLOATS}},
    {"oversampled", oversampled, {OBJECT, 1, 0.7, IF_TRANSLUCENT, 0, INT16}},
    {"samples without a value", voids, {OBJECT, 1, 0.7, IF_TRANSLUCENT, 0, FLOATS}},
    {"background", background, {IMAGE, 1, 0.7, 0, 0, INT16}},
    {"one value", constant, {IMAGE, 1, 0.7, 0, 0, FLOATS}},
    {"AVX2", avx2, {IMAGE, 1, 0.7, 0, 0, FLOATS}},
    {"surface", surface, {OBJECT, 1, 0.7, 0, 0, FLOATS}},
    {"mip", mip, {OBJECT, 1.5, 0.7, IF_TRANSLUCENT, 0, INT16}},
    {"mip, AVX2", mip_avx2, {OBJECT, 1.5, 0.7, IF_TRANSLUCENT, 0, FLOATS}},
    {"mip of a level", mip_level, {OBJECT, 1.5, 0.7, IF_TRANSLUCENT, 0, FLOATS}},
    {"xray", xray, {OBJECT, 1.5, 1.3, IF_TRANSLUCENT, 0, FLOATS}},
    {"xray, order asked for", xray_asked, {OBJECT, 1, 0.7, IF_TRANSLUCENT, 0, FLOATS}},
};

static void test_cases(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        cvol_policy_case in = usual();
        rows[i].change(&in);
        const cvol_policy is = cvol_policy_choose(&in), *e = &rows[i].expected;
        const int same = is.order == e->order && fabs(is.rays_apart - e->rays_apart) < 1e-9 &&
                         fabs(is.coarsest - e->coarsest) < 1e-9 && is.intervals == e->intervals &&
                         is.gradient_interpolation == e->gradient_interpolation &&
                         is.samples == e->samples;
        if (!same)
            print_message("%s: order %d, apart %g, coarsest %g, intervals %d, gradients %d, "
                          "samples %d\n",
                          rows[i].name, (int)is.order, is.rays_apart, is.coarsest,
                          (int)is.intervals, is.gradient_interpolation, (int)is.samples);
        assert_true(same);
    }
}

/* Every case has a kernel, on every processor, and int16 samples are lit only where they suffice.
 */
static void test_every_case_has_a_kernel(void **state)
{
    (void)state;
    for (int bits = 0; bits < 1 << 12; bits++)
        for (int mode = CVOL_MODE_COMPOSITE; mode <= CVOL_MODE_ISO; mode++) {
            cvol_policy_case in = usual();
            in.mode = (cvol_mode)mode;
            in.lit = mode == CVOL_MODE_ISO || (mode == CVOL_MODE_COMPOSITE && (bits & 1));
            in.has_depth = bits >> 1 & 1;
            in.is_wide = bits >> 2 & 1;
            in.level = bits >> 3 & 1;
            in.perspective = bits >> 4 & 1;
            in.counts = bits >> 5 & 1;
            in.masked = bits >> 6 & 1 ? CVOL_SHEET_SOME_VOID : CVOL_SHEET_ALL_PLAIN;
            in.is_oblique = bits >> 7 & 1;
            in.cpu = (cvol_cpu)((bits >> 8 & 3) % 3);
            in.traits.noise = bits >> 10 & 1 ? 0.1 : 0;
            in.fits_lit_int16 = bits >> 11 & 1;
            const cvol_policy is = cvol_policy_choose(&in);
            const int is_image = is.order == IMAGE;
            assert_true(is_image || is.order == OBJECT);
            if (in.lit && is.samples == INT16)
                assert_true(is_image && in.fits_lit_int16 && in.cpu == CVOL_CPU_AVX512);
            const cvol_kernel_key key = {.mode = in.mode,
                                         .is_image_order = is_image,
                                         .is_lit = in.lit,
                                         .is_int16 = is.samples == INT16,
                                         .has_extras = in.has_depth || in.is_wide || in.counts};
            if (!(key.is_int16 && key.has_extras))
                assert_non_null(cvol_sheet_kernel_find(&key, cvol_cpu_best()));
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cases),
                                       cmocka_unit_test(test_every_case_has_a_kernel)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
