/* From samples to compressed planes. */
#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/memory.h"
#include "base/thread.h"
#include "render/transform.h"

/* The next length of which a transform is fast: 2^a 3^b 5^c, even. */
static size_t fast_length(size_t n)
{
    for (n += n & 1;; n += 2) {
        size_t rest = n;
        for (size_t p = 2; p <= 5; p += p == 2 ? 1 : 2)
            while (rest % p == 0)
                rest /= p;
        if (rest == 1)
            return n;
    }
}

cvol_lattice cvol_lattice_make(const cvol_splat_plan *plan, int reach)
{
    const double(*along)[2] = plan->along;
    const double determinant = along[0][0] * along[1][1] - along[0][1] * along[1][0];
    cvol_lattice out = {.reach = (size_t)reach, .samples = plan->lanes * plan->rows};
    out.shear[0] = (along[2][0] * along[1][1] - along[2][1] * along[1][0]) / determinant;
    out.shear[1] = (along[0][0] * along[2][1] - along[0][1] * along[2][0]) / determinant;
    const size_t samples[2] = {plan->lanes, plan->rows};
    for (int a = 0; a < 2; a++) {
        const double drift = out.shear[a] * (double)(plan->slices - 1);
        out.base[a] = reach + fmax(-drift, 0);
        out.dims[a] = fast_length(samples[a] + (size_t)ceil(fabs(drift)) + 2 * (size_t)reach);
    }
    return out;
}

cvol_keep cvol_transform_keep(const cvol_transform_options *options, const cvol_lattice *lattice)
{
    const double places = (double)lattice->dims[0] * (double)lattice->dims[1];
    return options->rho >= 1 ? cvol_keep_all()
                             : cvol_keep_rho(options->rho * (double)lattice->samples / places);
}

/* One slice's planes; 0 if nothing of it can be seen. */
static int classify(float *planes[CVOL_PLANES], const cvol_splat_slab *slab, size_t place,
                    const cvol_splat_plan *plan, const cvol_lattice *lattice,
                    const cvol_splat_table *table, const cvol_splat_light *light,
                    cvol_splat_list *list)
{
    const size_t P = lattice->dims[0], stride = slab->row_stride, slice = slab->slice_stride;
    const size_t last = plan->slices - 1, reach = lattice->reach;
    int any = 0;
    for (int c = 0; c < CVOL_PLANES; c++)
        memset(planes[c], 0, P * lattice->dims[1] * sizeof *planes[c]);
    for (size_t j = 0; j < plan->rows; j++) {
        const float *samples = cvol_splat_slab_at(slab, place) + j * stride;
        const cvol_splat_row row = {samples, j > 0 ? samples - stride : samples,
                                    j + 1 < plan->rows ? samples + stride : samples,
                                    place > 0 ? samples - slice : samples,
                                    place < last ? samples + slice : samples};
        CVOL_SIMD_CHOOSE(cvol_splat_list_make)
        (list, &row, 0, (int)plan->lanes, table, light);
        for (int n = 0; n < list->count; n++)
            for (int c = 0; c < CVOL_PLANES; c++)
                planes[c][(size_t)list->numbers[n] + reach + P * (j + reach)] =
                    list->from[CVOL_PLANES * list->entries[n] + c];
        any |= list->count > 0;
    }
    return any;
}

/* What a thread works with. */
typedef struct baker {
    cvol_context context; /* of one thread, and without progress */
    float *planes[CVOL_PLANES];
    cvol_splat_list list;
    int code;
} baker;

static void free_bakers(baker *bakers, int count)
{
    for (int t = 0; bakers && t < count; t++) {
        for (int c = 0; c < CVOL_PLANES; c++)
            free(bakers[t].planes[c]);
        free(bakers[t].list.numbers);
        free(bakers[t].list.entries);
        free(bakers[t].list.channels);
    }
    free(bakers);
}

static baker *make_bakers(const cvol_context *context, int count, const cvol_splat_plan *plan,
                          size_t places)
{
    baker *bakers = calloc((size_t)count, sizeof *bakers);
    int made = bakers != NULL;
    for (int t = 0; made && t < count; t++) {
        baker *b = &bakers[t];
        b->context = *context;
        b->context.threads = 1;
        b->context.progress = NULL;
        const size_t room = plan->lanes + CVOL_SPLAT_MARGIN;
        b->list.numbers = cvol_allocate_zero(room, sizeof *b->list.numbers);
        b->list.entries = cvol_allocate_zero(room, sizeof *b->list.entries);
        b->list.channels = cvol_allocate(CVOL_SPLAT_CHANNELS * plan->lanes, sizeof(float));
        made = b->list.numbers && b->list.entries && b->list.channels;
        for (int c = 0; c < CVOL_PLANES; c++)
            made = made && (b->planes[c] = cvol_allocate(places, sizeof(float)));
    }
    if (made)
        return bakers;
    free_bakers(bakers, count);
    return NULL;
}

static void compress(baker *b, cvol_baked *out, size_t k, const cvol_transform_options *options)
{
    const cvol_lattice *lattice = &out->lattice;
    const cvol_grid grid = cvol_grid_make(lattice->dims[0], lattice->dims[1], 1, CVOL_FLOAT32);
    const cvol_keep keep = cvol_transform_keep(options, lattice);
    for (int c = 0; c < CVOL_PLANES && !b->code; c++)
        b->code = cvol_array_compress(&b->context, &out->planes[k][c], b->planes[c], &grid, 2,
                                      options->transform, 0, &keep);
}

static void count_terms(cvol_baked *baked)
{
    for (size_t k = 0; k < baked->slices; k++)
        for (int c = 0; c < CVOL_PLANES && baked->planes[k][c]; c++) {
            cvol_array_info info;
            cvol_array_get_info(baked->planes[k][c], &info);
            baked->terms += info.coefficients;
            baked->bytes += info.resident_bytes;
        }
}

int cvol_bake(cvol_context *context, cvol_baked *out, const cvol_splat_source *source,
              const cvol_splat_plan *plan, const cvol_lattice *lattice,
              const cvol_splat_table *table, const cvol_splat_light *light, int ascending,
              const cvol_transform_options *options)
{
    const size_t places = lattice->dims[0] * lattice->dims[1];
    const int threads = cvol_context_threads(context);
    cvol_splat_slab slab = {0};
    *out = (cvol_baked){.lattice = *lattice, .slices = plan->slices};
    int code = cvol_splat_slab_prepare(context, &slab, source, plan);
    if (code)
        return code;
    out->planes = calloc(plan->slices, sizeof *out->planes);
    baker *bakers = make_bakers(context, threads, plan, places);
    if (!out->planes || !bakers)
        code = cvol_fail_memory(context, CVOL_PLANES * places * sizeof(float), "planes of a slice");
    for (size_t done = 0; done < plan->slices && !code;) {
        code = cvol_splat_slab_next(context, &slab, source, plan, ascending);
        /* The last slice of a slab waits for its neighbour. */
        const size_t loaded = slab.first + slab.filled;
        const size_t end = loaded < plan->slices ? loaded - 1 : plan->slices;
#pragma omp parallel for schedule(dynamic) num_threads(threads)
        for (size_t place = done; place < end; place++) {
            baker *b = &bakers[cvol_thread_index()];
            const size_t k = ascending ? place : plan->slices - 1 - place;
            if (!b->code &&
                classify(b->planes, &slab, place, plan, lattice, table, light, &b->list))
                compress(b, out, k, options);
        }
        done = end;
        for (int t = 0; t < threads && !code; t++)
            if (bakers[t].code)
                code = cvol_fail(context, bakers[t].code, "%s", bakers[t].context.message);
        if (!code)
            code = cvol_report_progress(context, "transforming slices",
                                        (double)done / (double)plan->slices);
    }
    if (!code)
        count_terms(out);
    free_bakers(bakers, threads);
    cvol_splat_slab_free(&slab);
    return code;
}

void cvol_baked_free(cvol_baked *baked)
{
    for (size_t k = 0; baked->planes && k < baked->slices; k++)
        for (int c = 0; c < CVOL_PLANES; c++)
            cvol_array_free(baked->planes[k][c]);
    free(baked->planes);
    *baked = (cvol_baked){0};
}
