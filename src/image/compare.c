/* The distance of two pictures: mean squared difference, PSNR and structural similarity.
 *
 * Structural similarity (Wang, Bovik, Sheikh, Simoncelli: Image quality assessment, IEEE TIP 13(4),
 * 2004), for each channel and each 7 x 7 window within the picture:
 *
 *     S = (2 ma mb + C1) (2 cab + C2) / ((ma^2 + mb^2 + C1) (va + vb + C2)),
 *     C1 = (0.01 255)^2, C2 = (0.03 255)^2,
 *
 * m the window's mean, v and c its sample variance and covariance (divided by 48, not 49). The
 * result is the mean over windows and channels: what scikit-image's structural_similarity gives
 * with channel_axis = 2 and data_range = 255. Along an axis of fewer than 7 pixels the window is
 * as wide as the picture; the variance of a window of one pixel is 0.
 *
 * Sums of squares are exact integers and the windows are added up row by row in order, so that
 * the figures do not depend on the number of threads.
 */
#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"
#include "image/pixels.h"

#define WINDOW 7
#define CHANNELS 3
#define PEAK 255.0
/* A pixel is foreground if a channel is above this. */
#define BACKGROUND_MAX 2

/* ---- differences ----------------------------------------------------------------------- */

/* Sums over a picture: all squares, those of the foreground, its pixels, the largest difference.
 * Sums over 32768^2 pixels stay below 2^48. */
typedef struct picture_sums {
    uint64_t squares, foreground_squares;
    size_t foreground_pixels;
    int max;
} picture_sums;

static void add_pixel(picture_sums *sums, const uint8_t *a, const uint8_t *b)
{
    uint64_t squares = 0;
    int brightest = 0;
    for (int c = 0; c < CHANNELS; c++) {
        int difference = abs(a[c] - b[c]);
        squares += (uint64_t)(difference * difference);
        sums->max = difference > sums->max ? difference : sums->max;
        brightest = a[c] > brightest ? a[c] : brightest;
        brightest = b[c] > brightest ? b[c] : brightest;
    }
    sums->squares += squares;
    if (brightest > BACKGROUND_MAX) {
        sums->foreground_squares += squares;
        sums->foreground_pixels++;
    }
}

static picture_sums sum_picture(const cvol_image *a, const cvol_image *b)
{
    size_t pixels = (size_t)a->width * (size_t)a->height;
    picture_sums sums = {0};
    for (size_t i = 0; i < pixels; i++)
        add_pixel(&sums, a->rgba + 4 * i, b->rgba + 4 * i);
    return sums;
}

static double psnr_of(uint64_t squares, size_t pixels)
{
    if (squares == 0)
        return INFINITY;
    return 10 * log10(PEAK * PEAK * CHANNELS * (double)pixels / (double)squares);
}

/* ---- structural similarity ------------------------------------------------------------- */

/* Sums over a window (or a column of it) of a, b and their products. The largest, 49 * 255^2,
 * fits an int many times over. */
typedef struct moments {
    int a, b, aa, bb, ab;
} moments;

static void add_column(moments *sum, const moments *column, int sign)
{
    sum->a += sign * column->a;
    sum->b += sign * column->b;
    sum->aa += sign * column->aa;
    sum->bb += sign * column->bb;
    sum->ab += sign * column->ab;
}

static moments column_moments(const uint8_t *a, const uint8_t *b, size_t stride, int height)
{
    moments sum = {0};
    for (int j = 0; j < height; j++) {
        int va = a[(size_t)j * stride], vb = b[(size_t)j * stride];
        sum.a += va;
        sum.b += vb;
        sum.aa += va * va;
        sum.bb += vb * vb;
        sum.ab += va * vb;
    }
    return sum;
}

static double similarity(const moments *sum, int count)
{
    const double c1 = (0.01 * PEAK) * (0.01 * PEAK), c2 = (0.03 * PEAK) * (0.03 * PEAK);
    double n = count, sample = count > 1 ? n / (n - 1) : 0;
    double ma = sum->a / n, mb = sum->b / n;
    double va = sample * (sum->aa / n - ma * ma);
    double vb = sample * (sum->bb / n - mb * mb);
    double cab = sample * (sum->ab / n - ma * mb);
    return (2 * ma * mb + c1) * (2 * cab + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
}

/* The sum of S over the windows whose top row is j, one channel. */
static double ssim_row(const cvol_image *a, const cvol_image *b, int j, int channel, int window_x,
                       int window_y)
{
    size_t stride = 4 * (size_t)a->width;
    const uint8_t *row_a = a->rgba + (size_t)j * stride + (size_t)channel;
    const uint8_t *row_b = b->rgba + (size_t)j * stride + (size_t)channel;
    moments columns[WINDOW] = {{0}}, sum = {0};
    double total = 0;
    for (int i = 0; i < a->width; i++) {
        moments *column = &columns[i % window_x]; /* the row that leaves the window */
        add_column(&sum, column, -1);
        *column = column_moments(row_a + 4 * (size_t)i, row_b + 4 * (size_t)i, stride, window_y);
        add_column(&sum, column, 1);
        if (i + 1 >= window_x)
            total += similarity(&sum, window_x * window_y);
    }
    return total;
}

static int ssim_of(cvol_context *context, double *out, const cvol_image *a, const cvol_image *b)
{
    int window_x = a->width < WINDOW ? a->width : WINDOW;
    int window_y = a->height < WINDOW ? a->height : WINDOW;
    int rows = a->height - window_y + 1, columns = a->width - window_x + 1;
    double *sums = cvol_allocate((size_t)rows, sizeof *sums);
    if (!sums)
        return cvol_fail_memory(context, (size_t)rows * sizeof *sums, "comparing pictures");
#pragma omp parallel for schedule(static) num_threads(cvol_context_threads(context))
    for (int j = 0; j < rows; j++) {
        sums[j] = 0;
        for (int c = 0; c < CHANNELS; c++)
            sums[j] += ssim_row(a, b, j, c, window_x, window_y);
    }
    double total = 0;
    for (int j = 0; j < rows; j++)
        total += sums[j];
    free(sums);
    *out = total / ((double)rows * columns * CHANNELS);
    return CVOL_OK;
}

int cvol_image_compare(cvol_context *context, cvol_image_difference *out, const cvol_image *a,
                       const cvol_image *b)
{
    *out = (cvol_image_difference){0};
    if (a->width != b->width || a->height != b->height)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "the pictures differ in size: %d x %d and %d x %d pixels", a->width,
                         a->height, b->width, b->height);
    int code = cvol_image_need_bytes(context, a, "comparing");
    if (!code)
        code = cvol_image_need_bytes(context, b, "comparing");
    if (code)
        return code;
    size_t pixels = (size_t)a->width * (size_t)a->height;
    picture_sums sums = sum_picture(a, b);
    out->psnr_db = psnr_of(sums.squares, pixels);
    out->psnr_foreground_db = psnr_of(sums.foreground_squares, sums.foreground_pixels);
    out->rmse = sqrt((double)sums.squares / (CHANNELS * (double)pixels));
    out->max_abs_error = sums.max;
    out->foreground_pixels = sums.foreground_pixels;
    return ssim_of(context, &out->ssim, a, b);
}
