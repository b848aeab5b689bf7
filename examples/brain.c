/* Three dimensions: the change between two scans of a brain, under a soft mask.
 *
 * The second scan is the first one with a faint lesion and a higher gain. The program compresses
 * both to 1/30, computes their difference (add) and its product with a smooth mask (multiply) on
 * coefficients, and renders the result without decompressing it. It writes brain_before.png,
 * brain_after.png and brain_change.png. usage: brain samples/ch2better.nii.gz */
#include "example.h"

/* The second time point: 4 % more gain, and a ball of +60 that fades out. */
static void make_second(cvol_volume *second, const cvol_volume *first)
{
    const size_t *n = first->grid.dims;
    const uint8_t *from = first->data;
    uint8_t *to = second->data;
    for (size_t z = 0; z < n[2]; z++)
        for (size_t y = 0; y < n[1]; y++)
            for (size_t x = 0; x < n[0]; x++) {
                const size_t i = x + n[0] * (y + n[1] * z);
                const double dx = (double)x - 0.35 * (double)n[0];
                const double dy = (double)y - 0.60 * (double)n[1];
                const double dz = (double)z - 0.55 * (double)n[2];
                const double lesion = 60 * exp(-(dx * dx + dy * dy + dz * dz) / (2 * 64));
                const double value = 1.04 * from[i] + (from[i] > 0 ? lesion : 0);
                to[i] = (uint8_t)(value > 255 ? 255 : value + 0.5);
            }
}

/* An ellipsoid with a soft edge: 1 inside, 0 outside. */
static void make_mask(float *mask, const cvol_grid *grid)
{
    const size_t *n = grid->dims;
    for (size_t z = 0; z < n[2]; z++)
        for (size_t y = 0; y < n[1]; y++)
            for (size_t x = 0; x < n[0]; x++) {
                const double dx = ((double)x + 0.5) / (double)n[0] - 0.5;
                const double dy = ((double)y + 0.5) / (double)n[1] - 0.5;
                const double dz = ((double)z + 0.5) / (double)n[2] - 0.5;
                const double r = sqrt(dx * dx + dy * dy + dz * dz);
                mask[x + n[0] * (y + n[1] * z)] = (float)(1 / (1 + exp(50 * (r - 0.38))));
            }
}

static cvol_array *compress(cvol_context *context, const void *samples, const cvol_grid *grid)
{
    const cvol_compress_options options = cvol_compress_options_defaults();
    cvol_array *array;
    must(context, cvol_compress(context, &array, NULL, samples, grid, &options));
    return array;
}

/* From above and to the left. */
static void render(cvol_context *context, const cvol_array *array, const cvol_transfer *transfer,
                   const char *path)
{
    cvol_renderer *renderer;
    cvol_image *image;
    cvol_render_options options = cvol_render_options_defaults();
    options.camera.azimuth_deg = 215;
    options.camera.elevation_deg = 35;
    options.camera.zoom = 1.5;
    must(context,
         cvol_renderer_create(context, &renderer, CVOL_ENGINE_SHEET, CVOL_SOURCE(.array = array)));
    must(context, cvol_renderer_set_transfer(context, renderer, transfer));
    must(context, cvol_image_create(context, &image, options.width, options.height));
    must(context, cvol_renderer_render(context, renderer, image, &options));
    must(context, cvol_image_write_png(context, image, path));
    printf("wrote %s\n", path);
    cvol_image_free(image);
    cvol_renderer_free(renderer);
}

static cvol_transfer *make_transfer(cvol_context *context, const cvol_transfer_point *points,
                                    size_t count)
{
    cvol_transfer *transfer;
    must(context, cvol_transfer_create(context, &transfer, points, count));
    return transfer;
}

/* (second - 1.04 first) mask, sample by sample. */
static float *change_exactly(const cvol_volume *first, const cvol_volume *second, const float *mask)
{
    const size_t count = cvol_grid_samples(&first->grid);
    const uint8_t *a = first->data, *b = second->data;
    float *exact = need_memory(malloc(count * sizeof *exact));
    for (size_t i = 0; i < count; i++)
        exact[i] = (float)((b[i] - 1.04 * a[i]) * (double)mask[i]);
    return exact;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: brain SCAN.nii.gz\n");
        return 2;
    }
    cvol_context *context = need_memory(cvol_context_create());
    cvol_volume *first, *second;
    must(context, cvol_volume_read(context, &first, argv[1], NULL));
    if (first->grid.type != CVOL_UINT8) {
        fprintf(stderr, "%s: samples are not uint8\n", argv[1]);
        return 1;
    }
    must(context, cvol_volume_create(context, &second, &first->grid));
    make_second(second, first);
    cvol_grid real = first->grid;
    real.type = CVOL_FLOAT32;
    float *mask = need_memory(malloc(cvol_grid_samples(&real) * sizeof *mask));
    make_mask(mask, &real);

    cvol_array *a = compress(context, first->data, &first->grid);
    cvol_array *b = compress(context, second->data, &second->grid);
    cvol_array *m = compress(context, mask, &real), *difference, *change;
    must(context, cvol_array_add(context, &difference, 1, b, -1.04, a, NULL));
    must(context, cvol_array_multiply(context, &change, difference, m, NULL, CVOL_PLAN_AUTO, NULL));
    float *exact = change_exactly(first, second, mask);
    report(context, "masked change", change, exact);

    const cvol_transfer_point tissue[] = {
        {40, 0.1, 0.05, 0.05, 0}, {90, 0.8, 0.5, 0.4, 0.02}, {200, 1, 1, 0.95, 0.15}};
    const cvol_transfer_point warm[] = {
        {12, 0.3, 0, 0, 0}, {30, 1, 0.3, 0, 0.05}, {60, 1, 1, 0.6, 0.3}};
    cvol_transfer *of_tissue = make_transfer(context, tissue, 3);
    cvol_transfer *of_change = make_transfer(context, warm, 3);
    render(context, a, of_tissue, "brain_before.png");
    render(context, b, of_tissue, "brain_after.png");
    render(context, change, of_change, "brain_change.png");

    cvol_transfer_free(of_tissue);
    cvol_transfer_free(of_change);
    cvol_array_free(a);
    cvol_array_free(b);
    cvol_array_free(m);
    cvol_array_free(difference);
    cvol_array_free(change);
    cvol_volume_free(first);
    cvol_volume_free(second);
    cvol_context_free(context);
    free(mask);
    free(exact);
    return 0;
}
