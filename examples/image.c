/* Two dimensions: sharpens a picture and darkens its edges, without decompressing it.
 *
 * The program compresses a slice of the brain scan in 8 x 8 DCT blocks to a tenth of the terms,
 * sharpens it by an unsharp mask (a kernel, exact across block faces) and multiplies it by a soft
 * disc. It writes image.png: the original, the compressed and the processed slice, side by side.
 * usage: image samples/ch2better.nii.gz */
#include <string.h>

#include "example.h"

/* The middle slice along z. */
static float *read_slice(cvol_context *context, const char *path, cvol_grid *grid)
{
    cvol_volume *volume;
    must(context, cvol_volume_read(context, &volume, path, NULL));
    if (volume->grid.type != CVOL_UINT8) {
        fprintf(stderr, "%s: samples are not uint8\n", path);
        exit(1);
    }
    const size_t width = volume->grid.dims[0], height = volume->grid.dims[1];
    const uint8_t *from = (const uint8_t *)volume->data + volume->grid.dims[2] / 2 * width * height;
    float *slice = need_memory(malloc(width * height * sizeof *slice));
    for (size_t i = 0; i < width * height; i++)
        slice[i] = from[i];
    *grid = cvol_grid_make(width, height, 1, CVOL_FLOAT32);
    cvol_volume_free(volume);
    return slice;
}

static float *make_disc(const cvol_grid *grid)
{
    const size_t width = grid->dims[0], height = grid->dims[1];
    float *disc = need_memory(malloc(width * height * sizeof *disc));
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            const double dx = ((double)x + 0.5) / (double)width - 0.5;
            const double dy = ((double)y + 0.5) / (double)height - 0.5;
            disc[x + width * y] = (float)(1 / (1 + exp(40 * (sqrt(dx * dx + dy * dy) - 0.4))));
        }
    return disc;
}

static size_t mirrored(long i, size_t n)
{
    return (size_t)(i < 0 ? -1 - i : i < (long)n ? i : 2 * (long)n - 1 - i);
}

/* Applies part `part` of the kernel along one axis to samples. */
static void filter_axis(float *out, const float *in, const cvol_grid *grid,
                        const cvol_kernel_line *line, int axis)
{
    const size_t width = grid->dims[0], height = grid->dims[1];
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            double sum = 0;
            for (int m = -line->radius; m <= line->radius; m++) {
                size_t at = axis == 0 ? mirrored((long)x - m, width) + width * y
                                      : x + width * mirrored((long)y - m, height);
                sum += line->taps[abs(m)] * (double)in[at];
            }
            out[x + width * y] = (float)sum;
        }
}

static void sharpen_exactly(float *out, const float *slice, const cvol_grid *grid,
                            const cvol_kernel *kernel)
{
    const size_t count = cvol_grid_samples(grid);
    float *first = need_memory(malloc(count * sizeof *first));
    float *second = need_memory(malloc(count * sizeof *second));
    memset(out, 0, count * sizeof *out);
    for (int part = 0; part < kernel->parts; part++) {
        filter_axis(first, slice, grid, &kernel->line[part][0], 0);
        filter_axis(second, first, grid, &kernel->line[part][1], 1);
        for (size_t i = 0; i < count; i++)
            out[i] += (float)(kernel->weight[part] * (double)second[i]);
    }
    free(first);
    free(second);
}

/* Draws samples 0 .. 255 at column `left`, twice their size. */
static void draw(cvol_image *image, int left, const float *samples, const cvol_grid *grid)
{
    const int width = (int)grid->dims[0], height = (int)grid->dims[1];
    for (int y = 0; y < 2 * height; y++)
        for (int x = 0; x < 2 * width; x++) {
            const float value = samples[x / 2 + width * ((2 * height - 1 - y) / 2)];
            uint8_t *pixel = image->rgba +
                             4 * ((size_t)y * (size_t)image->width + (size_t)(left + x));
            for (int c = 0; c < 3; c++)
                pixel[c] = (uint8_t)(value < 0 ? 0 : value > 255 ? 255 : value);
            pixel[3] = 255;
        }
}

static void draw_array(cvol_context *context, cvol_image *image, int left, const cvol_array *array)
{
    const cvol_grid *grid = cvol_array_grid(array);
    const size_t begin[3] = {0, 0, 0};
    float *samples = need_memory(malloc(cvol_grid_samples(grid) * sizeof *samples));
    must(context, cvol_array_evaluate_real(context, samples, array, begin, grid->dims));
    draw(image, left, samples, grid);
    free(samples);
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "usage: image SCAN.nii.gz\n");
        return 2;
    }
    cvol_context *context = need_memory(cvol_context_create());
    cvol_grid grid;
    float *slice = read_slice(context, argv[1], &grid), *disc = make_disc(&grid);
    const size_t count = cvol_grid_samples(&grid);
    float *exact = need_memory(malloc(count * sizeof *exact));

    cvol_array *picture, *mask, *sharp, *result;
    const cvol_keep tenth = cvol_keep_rho(0.1), fine = cvol_keep_psnr(60);
    must(context, cvol_array_compress(context, &picture, slice, &grid, 2, CVOL_DCT, 8, &tenth));
    must(context, cvol_array_compress(context, &mask, disc, &grid, 2, CVOL_DCT, 8, &fine));
    report(context, "slice", picture, slice);
    report(context, "disc", mask, disc);

    cvol_kernel unsharp;
    must(context, cvol_kernel_unsharp(context, &unsharp, 2, 0.7, 1.5));
    must(context, cvol_array_convolve_kernel(context, &sharp, picture, &unsharp, &tenth));
    sharpen_exactly(exact, slice, &grid, &unsharp);
    report(context, "sharpened (convolve)", sharp, exact);

    must(context, cvol_array_multiply(context, &result, sharp, mask, &tenth, CVOL_PLAN_AUTO, NULL));
    for (size_t i = 0; i < count; i++)
        exact[i] *= disc[i];
    report(context, "vignetted (multiply)", result, exact);

    cvol_image *image;
    const int width = 2 * (int)grid.dims[0];
    must(context, cvol_image_create(context, &image, 3 * width, 2 * (int)grid.dims[1]));
    draw(image, 0, slice, &grid);
    draw_array(context, image, width, picture);
    draw_array(context, image, 2 * width, result);
    must(context, cvol_image_write_png(context, image, "image.png"));
    printf("wrote image.png: the slice, compressed, processed\n");

    cvol_image_free(image);
    cvol_array_free(picture);
    cvol_array_free(mask);
    cvol_array_free(sharp);
    cvol_array_free(result);
    cvol_context_free(context);
    free(slice);
    free(disc);
    free(exact);
    return 0;
}
