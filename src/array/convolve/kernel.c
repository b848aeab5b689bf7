/* Small filters: construction and their effect on norms.
 *
 * A line of taps g has the response H(omega) = sum_i g[i] exp(-i omega i): for a symmetric line the
 * real g[0] + 2 sum_{i > 0} g[i] cos(i omega), for an antisymmetric one i times the real -2 sum_{i
 * > 0} g[i] sin(i omega). At an extremum omega* of H, H'(omega*) = 0, so a sample at most d / 2
 * away misses H(omega*) by at most max |H''| d^2 / 8 (Taylor). Samples at distance d, with that
 * slack, give an interval that contains H everywhere. Intervals are multiplied over the axes and
 * added over the parts.
 *
 * Parts that are antisymmetric along the same axes form a class. Within a class max |H| is the
 * operator's norm on periodic arrays and on mirrored ones (the result is symmetric or antisymmetric
 * about the ends, so half of the energy of twice the array lies in the array). On mirrored arrays
 * the sum of two classes may exceed |H|: h = delta(x - 1) has |H| = 1 and repeats the first sample.
 * So the norms of classes are added, for any extension. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "array/convolve/kernel.h"
#include "base/c_locale.h"
#include "base/context.h"
#include "base/elementary.h"

static const double PI = 3.14159265358979323846;

/* Margin for rounding of sums of some tens of doubles. */
static const double SLACK = 1e-13;

/* ---- responses and bounds -------------------------------------------------------------------- */

double cvol_kernel_response(const cvol_kernel_line *line, double omega)
{
    /* Clenshaw: b_i = g_i + 2 cos(omega) b_{i+1} - b_{i+2} */
    double at[2]; /* cosine and sine */
    cvol_sincos(at, omega);
    const double turn = 2 * at[0];
    double next = 0, after = 0;
    for (int i = line->radius; i > 0; i--) {
        const double now = line->taps[i] + turn * next - after;
        after = next;
        next = now;
    }
    if (line->antisymmetric)
        return -2 * at[1] * next;
    return line->taps[0] + turn * next - 2 * after;
}

static double line_sum(const cvol_kernel_line *line)
{
    double sum = fabs(line->taps[0]);
    for (int i = 1; i <= line->radius; i++)
        sum += 2 * fabs(line->taps[i]);
    return sum;
}

typedef struct interval {
    double lo, hi;
} interval;

static interval multiply(interval a, interval b)
{
    const double c[4] = {a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi};
    return (interval){fmin(fmin(c[0], c[1]), fmin(c[2], c[3])),
                      fmax(fmax(c[0], c[1]), fmax(c[2], c[3]))};
}

/* Contains H over all frequencies (of an antisymmetric line: H / i). */
static interval line_interval(const cvol_kernel_line *line)
{
    const int samples = 64 * (line->radius + 1);
    const double distance = PI / samples;
    interval out = {(double)INFINITY, -(double)INFINITY};
    for (int j = 0; j <= samples; j++) {
        const double h = cvol_kernel_response(line, j * distance);
        out.lo = fmin(out.lo, h);
        out.hi = fmax(out.hi, h);
    }
    double curvature = 0; /* bounds |H''| */
    for (int i = 1; i <= line->radius; i++)
        curvature += 2 * (double)i * i * fabs(line->taps[i]);
    const double sum = line_sum(line);
    const double slack = curvature * distance * distance / 8 + SLACK * sum;
    out.lo = fmax(out.lo - slack, -sum);
    out.hi = fmin(out.hi + slack, sum);
    if (line->antisymmetric) /* odd in omega; only half of the frequencies were sampled */
        out.lo = -(out.hi = fmax(-out.lo, out.hi));
    return out;
}

/* The axes along which a part is antisymmetric, as bits. */
static int class_of(const cvol_kernel *kernel, int part)
{
    int bits = 0;
    for (int a = 0; a < 3; a++)
        bits |= (kernel->line[part][a].antisymmetric != 0) << a;
    return bits;
}

void cvol_kernel_bounds(const cvol_kernel *kernel, double *norm, double *sum)
{
    interval values[8] = {{0, 0}};
    double sums[8] = {0};
    for (int t = 0; t < kernel->parts; t++) {
        const int bits = class_of(kernel, t);
        interval value = {kernel->weight[t], kernel->weight[t]};
        double product = fabs(kernel->weight[t]);
        for (int a = 0; a < 3; a++) {
            value = multiply(value, line_interval(&kernel->line[t][a]));
            product *= line_sum(&kernel->line[t][a]);
        }
        values[bits].lo += value.lo;
        values[bits].hi += value.hi;
        sums[bits] += product;
    }
    *norm = *sum = 0;
    for (int bits = 0; bits < 8; bits++) {
        const double largest = fmax(-values[bits].lo, values[bits].hi);
        *norm += fmin(largest + SLACK * sums[bits], sums[bits]);
        *sum += sums[bits];
    }
    *norm *= 1 + SLACK;
    *sum *= 1 + SLACK;
}

/* sum over x of f[x] g[x] */
static double line_inner(const cvol_kernel_line *f, const cvol_kernel_line *g)
{
    const int radius = f->radius < g->radius ? f->radius : g->radius;
    double sum = f->taps[0] * g->taps[0];
    if (f->antisymmetric != g->antisymmetric)
        return 0;
    for (int i = 1; i <= radius; i++)
        sum += 2 * f->taps[i] * g->taps[i];
    return sum;
}

double cvol_kernel_noise_gain(const cvol_kernel *kernel)
{
    double sum = 0;
    for (int s = 0; s < kernel->parts; s++)
        for (int t = 0; t < kernel->parts; t++) {
            double product = kernel->weight[s] * kernel->weight[t];
            for (int a = 0; a < 3; a++)
                product *= line_inner(&kernel->line[s][a], &kernel->line[t][a]);
            sum += product;
        }
    return sqrt(fmax(sum, 0));
}

int cvol_kernel_radius(const cvol_kernel *kernel, int axis)
{
    int radius = 0;
    for (int t = 0; t < kernel->parts; t++)
        if (kernel->line[t][axis].radius > radius)
            radius = kernel->line[t][axis].radius;
    return radius;
}

double cvol_kernel_outermost(const cvol_kernel *kernel)
{
    double most = 0;
    for (int axis = 0; axis < 3; axis++) {
        const int radius = cvol_kernel_radius(kernel, axis);
        double sum = 0;
        for (int t = 0; t < kernel->parts && radius; t++) {
            const cvol_kernel_line *line = kernel->line[t];
            double product = line[axis].radius == radius ? fabs(line[axis].taps[radius]) : 0;
            for (int a = 0; a < 3; a++)
                product *= a == axis ? 1 : line_sum(&line[a]);
            sum += fabs(kernel->weight[t]) * product;
        }
        most = fmax(most, sum);
    }
    return most;
}

int cvol_kernel_check(cvol_context *context, const cvol_kernel *kernel)
{
    if (kernel->parts < 1 || kernel->parts > CVOL_KERNEL_PARTS)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "kernel has %d parts, must be 1 to %d",
                         kernel->parts, CVOL_KERNEL_PARTS);
    for (int t = 0; t < kernel->parts; t++) {
        if (!isfinite(kernel->weight[t]))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "kernel: weight[%d] is %g, must be finite", t, kernel->weight[t]);
        for (int a = 0; a < 3; a++) {
            const cvol_kernel_line *line = &kernel->line[t][a];
            if (line->radius < 0 || line->radius > CVOL_KERNEL_RADIUS)
                return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                                 "kernel: line[%d][%d] has radius %d, must be 0 to %d", t, a,
                                 line->radius, CVOL_KERNEL_RADIUS);
            for (int i = 0; i <= line->radius; i++)
                if (!isfinite(line->taps[i]))
                    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                                     "kernel: line[%d][%d].taps[%d] is %g, must be finite", t, a, i,
                                     line->taps[i]);
            if (line->antisymmetric && line->taps[0] != 0)
                return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                                 "kernel: line[%d][%d] is antisymmetric, but taps[0] is %g", t, a,
                                 line->taps[0]);
        }
    }
    return CVOL_OK;
}

/* ---- making ---------------------------------------------------------------------------------- */

static int check_rank(cvol_context *context, int rank)
{
    if (rank >= 1 && rank <= 3)
        return CVOL_OK;
    return cvol_fail(context, CVOL_ERROR_ARGUMENT, "kernel: rank is %d, must be 1, 2 or 3", rank);
}

/* `parts` times the identity kernel. */
static cvol_kernel identity(int parts)
{
    cvol_kernel out;
    memset(&out, 0, sizeof out);
    out.parts = parts;
    for (int t = 0; t < parts; t++) {
        out.weight[t] = 1;
        for (int a = 0; a < 3; a++)
            out.line[t][a].taps[0] = 1;
    }
    return out;
}

static int gaussian_line(cvol_context *context, cvol_kernel_line *out, double sigma)
{
    memset(out, 0, sizeof *out);
    if (!(isfinite(sigma) && sigma > 0))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "kernel: sigma is %g, must be finite and above 0", sigma);
    if (4 * sigma > CVOL_KERNEL_RADIUS)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "kernel: sigma is %g, must be at most %g (a kernel reaches %d samples)",
                         sigma, CVOL_KERNEL_RADIUS / 4.0, CVOL_KERNEL_RADIUS);
    out->radius = (int)ceil(4 * sigma);
    double sum = 0;
    for (int i = out->radius; i >= 0; i--) {
        const double x = i / sigma;
        out->taps[i] = cvol_exp(-0.5 * x * x);
        sum += i ? 2 * out->taps[i] : out->taps[i];
    }
    for (int i = 0; i <= out->radius; i++)
        out->taps[i] /= sum;
    return CVOL_OK;
}

int cvol_kernel_gaussian(cvol_context *context, cvol_kernel *out, int rank, double sigma)
{
    cvol_kernel_line line;
    int code = check_rank(context, rank);
    if (!code)
        code = gaussian_line(context, &line, sigma);
    if (code)
        return code;
    *out = identity(1);
    for (int a = 0; a < rank; a++)
        out->line[0][a] = line;
    return CVOL_OK;
}

int cvol_kernel_box(cvol_context *context, cvol_kernel *out, int rank, int width)
{
    int code = check_rank(context, rank);
    if (code)
        return code;
    if (width < 1 || width % 2 == 0 || width / 2 > CVOL_KERNEL_RADIUS)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "kernel: width is %d, must be odd and between 1 and %d", width,
                         2 * CVOL_KERNEL_RADIUS + 1);
    *out = identity(1);
    for (int a = 0; a < rank; a++) {
        cvol_kernel_line *line = &out->line[0][a];
        line->radius = width / 2;
        for (int i = 0; i <= line->radius; i++)
            line->taps[i] = 1.0 / width;
    }
    return CVOL_OK;
}

int cvol_kernel_laplacian(cvol_context *context, cvol_kernel *out, int rank)
{
    int code = check_rank(context, rank);
    if (code)
        return code;
    *out = identity(rank);
    for (int a = 0; a < rank; a++) {
        out->line[a][a].radius = 1;
        out->line[a][a].taps[0] = -2;
        out->line[a][a].taps[1] = 1;
    }
    return CVOL_OK;
}

int cvol_kernel_unsharp(cvol_context *context, cvol_kernel *out, int rank, double sigma,
                        double amount)
{
    cvol_kernel_line line;
    int code = check_rank(context, rank);
    if (!code)
        code = gaussian_line(context, &line, sigma);
    if (!code && !isfinite(amount))
        code = cvol_fail(context, CVOL_ERROR_ARGUMENT, "kernel: amount is %g, must be finite",
                         amount);
    if (code)
        return code;
    *out = identity(2);
    out->weight[0] = 1 + amount;
    out->weight[1] = -amount;
    for (int a = 0; a < rank; a++)
        out->line[1][a] = line;
    return CVOL_OK;
}

int cvol_kernel_derivative(cvol_context *context, cvol_kernel *out, int rank, int axis)
{
    int code = check_rank(context, rank);
    if (code)
        return code;
    if (axis < 0 || axis >= rank)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "kernel: derivative along axis %d of an array of rank %d, must be 0 to %d",
                         axis, rank, rank - 1);
    *out = identity(1);
    cvol_kernel_line *line = &out->line[0][axis];
    line->radius = 1;
    line->antisymmetric = 1;
    line->taps[0] = 0;
    line->taps[1] = -0.5; /* h[1] takes a[x - 1] */
    return CVOL_OK;
}

int cvol_kernel_taps(cvol_context *context, cvol_kernel *out, int rank, const double *taps,
                     int radius)
{
    int code = check_rank(context, rank);
    if (code)
        return code;
    if (radius < 0 || radius > CVOL_KERNEL_RADIUS)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "kernel: radius is %d, must be 0 to %d",
                         radius, CVOL_KERNEL_RADIUS);
    double largest = 0, even = 0, odd = 0; /* distances from symmetric and from antisymmetric */
    for (int i = 0; i <= radius; i++) {
        const double left = taps[radius - i], right = taps[radius + i];
        if (!isfinite(left) || !isfinite(right))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT, "kernel: tap %d is not finite, must be",
                             isfinite(left) ? radius + i : radius - i);
        largest = fmax(largest, fmax(fabs(left), fabs(right)));
        even = fmax(even, fabs(left - right));
        odd = fmax(odd, fabs(left + right));
    }
    /* Written in decimals or computed, the two halves may differ by rounding. */
    const double tolerance = 1e-12 * largest;
    if (even > tolerance && odd > tolerance)
        return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                         "kernel: %d taps that are neither symmetric nor antisymmetric; split them "
                         "into (g[i] + g[-i]) / 2 and (g[i] - g[-i]) / 2",
                         2 * radius + 1);
    *out = identity(1);
    cvol_kernel_line line;
    memset(&line, 0, sizeof line);
    line.radius = radius;
    line.antisymmetric = even > tolerance;
    for (int i = line.antisymmetric; i <= radius; i++)
        line.taps[i] = taps[radius + i];
    for (int a = 0; a < rank; a++)
        out->line[0][a] = line;
    return CVOL_OK;
}

/* ---- parsing --------------------------------------------------------------------------------- */

static int unknown(cvol_context *context, const char *text)
{
    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                     "kernel '%.80s' is unknown; there are gaussian:SIGMA, box:WIDTH, laplacian, "
                     "unsharp:SIGMA[,AMOUNT], derivative:x|y|z",
                     text);
}

/* Reads a number that ends at `stop`; *at moves behind it. */
static int parse_number(cvol_context *context, double *out, const char *text, const char **at,
                        const char *stop, const char *what)
{
    char *end;
    errno = 0;
    *out = strtod(*at, &end);
    if (end == *at || !strchr(stop, *end) || errno == ERANGE || !isfinite(*out))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "kernel '%.80s': %s '%.40s' is not a number",
                         text, what, *at);
    *at = end;
    return CVOL_OK;
}

static int parse(cvol_context *context, cvol_kernel *out, int rank, const char *text)
{
    const char *colon = strchr(text, ':');
    const size_t length = colon ? (size_t)(colon - text) : strlen(text);
    const char *at = colon ? colon + 1 : text + length;
    double number, amount = 1;
    int code;
#define NAMED(name) (length == sizeof name - 1 && !memcmp(text, name, sizeof name - 1))
    if (NAMED("laplacian") && !colon)
        return cvol_kernel_laplacian(context, out, rank);
    if (NAMED("gaussian")) {
        code = parse_number(context, &number, text, &at, "", "sigma");
        return code ? code : cvol_kernel_gaussian(context, out, rank, number);
    }
    if (NAMED("box")) {
        code = parse_number(context, &number, text, &at, "", "width");
        if (!code && (number != floor(number) || fabs(number) > 1e6))
            code = cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "kernel '%.80s': width is %g, must be an odd whole number", text,
                             number);
        return code ? code : cvol_kernel_box(context, out, rank, (int)number);
    }
    if (NAMED("unsharp")) {
        code = parse_number(context, &number, text, &at, ",", "sigma");
        if (!code && *at) {
            at++;
            code = parse_number(context, &amount, text, &at, "", "amount");
        }
        return code ? code : cvol_kernel_unsharp(context, out, rank, number, amount);
    }
    if (NAMED("derivative")) {
        if (!*at || at[1] || !strchr("xyz", *at))
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "kernel '%.80s': axis '%.40s' is not x, y or z", text, at);
        if (rank >= 1 && rank <= 3 && *at - 'x' >= rank)
            return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                             "kernel '%.80s': an array of rank %d has no axis %c", text, rank, *at);
        return cvol_kernel_derivative(context, out, rank, *at - 'x');
    }
#undef NAMED
    return unknown(context, text);
}

int cvol_kernel_parse(cvol_context *context, cvol_kernel *out, int rank, const char *text)
{
    cvol_c_locale locale;
    int code = cvol_c_locale_enter(context, &locale);
    if (code)
        return code;
    code = parse(context, out, rank, text);
    cvol_c_locale_leave(&locale);
    return code;
}

double cvol_kernel_total(const cvol_kernel *kernel)
{
    double sum = 0;
    for (int p = 0; p < kernel->parts; p++) {
        double product = kernel->weight[p];
        for (int axis = 0; axis < 3; axis++)
            product *= kernel->line[p][axis].antisymmetric
                           ? 0
                           : cvol_kernel_response(&kernel->line[p][axis], 0);
        sum += product;
    }
    return sum;
}
