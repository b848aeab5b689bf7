/* The product of two arrays, samplewise: checks, the choice of a plan, the certified bound. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "array/algebra/operations.h"
#include "array/evaluate/decoded_terms.h"
#include "array/multiply/cost.h"
#include "array/multiply/low.h"
#include "array/multiply/multiply.h"
#include "array/truncate/account.h"
#include "array/truncate/producer.h"
#include "array/truncate/truncate.h"
#include "base/context.h"

/* Nanoseconds per sample of arrays in blocks, blocks of 16; see cost.c. */
#define NS_BLOCK_SAMPLE 6.0
#define NS_CUT 10.0 /* per term: to choose what the plan `low` leaves out */
#define LOW_MS 0.5  /* a product that takes less needs no shorter way */

static const char *const plan_names[] = {
    [CVOL_PLAN_AUTO] = "auto", [CVOL_PLAN_DIRECT] = "direct", [CVOL_PLAN_GRID] = "grid",
    [CVOL_PLAN_FULL] = "full", [CVOL_PLAN_SPARSE] = "sparse", [CVOL_PLAN_BLOCKS] = "blocks",
    [CVOL_PLAN_LOW] = "low"};

const char *cvol_plan_name(cvol_plan plan)
{
    return plan >= CVOL_PLAN_AUTO && plan <= CVOL_PLAN_LOW ? plan_names[plan] : NULL;
}

static uint64_t terms_of(const cvol_array *array)
{
    return array->block ? array->coefficients : array->whole.low_count + array->whole.sparse_count;
}

/* ---- selection of terms ---------------------------------------------------------------------- */

static int is_like_inputs(const cvol_keep *keep)
{
    return !keep || keep->rule == CVOL_KEEP_LIKE_INPUTS;
}

/* LIKE_INPUTS: a whole array keeps the larger low box and the larger number of sparse terms of the
 * two operands. Arrays in blocks resolve it themselves. */
static cvol_keep resolve_keep(const cvol_keep *keep, const cvol_array *a, const cvol_array *b)
{
    cvol_keep out = keep ? *keep : cvol_keep_like_inputs();
    if (out.rule != CVOL_KEEP_LIKE_INPUTS || a->block)
        return out;
    const cvol_spectrum *x = &a->whole, *y = &b->whole;
    out = (cvol_keep){.rule = CVOL_KEEP_TERMS};
    for (int i = 0; i < 3; i++)
        out.low[i] = x->low[i] > y->low[i] ? x->low[i] : y->low[i];
    out.sparse = x->sparse_count > y->sparse_count ? x->sparse_count : y->sparse_count;
    return out;
}

/* ---- the plan -------------------------------------------------------------------------------- */

static void find_costs(cvol_multiply_report *report, cvol_multiply_task *task, size_t points[3],
                       const cvol_array *a, const cvol_array *b, const cvol_keep *keep)
{
    for (int i = 0; i <= CVOL_PLAN_LOW; i++)
        report->cost_ms[i] = (double)INFINITY;
    if (a->block) {
        report->cost_ms[CVOL_PLAN_BLOCKS] = 1e-6 * NS_BLOCK_SAMPLE *
                                            (double)cvol_grid_samples(&a->grid);
        return;
    }
    *task = cvol_multiply_task_of(a, b, keep);
    cvol_multiply_points(points, task);
    report->cost_ms[CVOL_PLAN_DIRECT] = cvol_multiply_cost_direct(task);
    report->cost_ms[CVOL_PLAN_GRID] = cvol_multiply_cost_grid(task, points);
    report->cost_ms[CVOL_PLAN_FULL] = cvol_multiply_cost_grid(task, a->grid.dims);
    report->cost_ms[CVOL_PLAN_SPARSE] = cvol_multiply_cost_sparse(task);
}

/* The cheapest plan; of equal ones the one named last, so `full` if the grid has all points. */
static cvol_plan cheapest(const double cost_ms[], int with_sparse)
{
    cvol_plan best = CVOL_PLAN_FULL;
    for (int p = CVOL_PLAN_DIRECT; p <= CVOL_PLAN_LOW; p++)
        if (cost_ms[p] < cost_ms[best] && (p != CVOL_PLAN_SPARSE || with_sparse))
            best = (cvol_plan)p;
    return best;
}

/* Chooses what the plan `low` leaves out, and adds its cost. asked: as the caller gave it. */
static int find_cost_low(cvol_context *context, cvol_multiply_report *report, cvol_low_cut *cut,
                         cvol_multiply_task task, const cvol_array *product, const cvol_array *a,
                         const cvol_array *b, const cvol_keep *asked, const cvol_keep *keep,
                         cvol_plan plan)
{
    cvol_low_limits limits;
    const double allowed = is_like_inputs(asked) ? -1 : cvol_array_allowed(product, asked);
    if (a->block || !cvol_low_limits_of(&limits, product, allowed, a, b))
        return CVOL_OK;
    const double others = report->cost_ms[cheapest(report->cost_ms, 0)];
    if (plan != CVOL_PLAN_LOW && (plan != CVOL_PLAN_AUTO || !(limits.lost > 0) || others < LOW_MS))
        return CVOL_OK;
    int code = cvol_low_choose(context, cut, a, b, task.extent, &limits);
    if (code)
        return code;
    /* Under L2 and PSNR truncation must see all terms, to meet the limit. */
    if (!is_like_inputs(asked) || !(cut->lost > 0))
        memset(cut->kept, 0, sizeof cut->kept);
    memcpy(task.extent, cut->extent, sizeof task.extent);
    cvol_low_candidates(task.most, cut, keep);
    size_t points[3];
    cvol_multiply_points(points, &task);
    report->cost_ms[CVOL_PLAN_LOW] = cvol_multiply_cost_grid(&task, points) +
                                     1e-6 * NS_CUT * (task.terms[0] + task.terms[1]);
    return CVOL_OK;
}

static int check_plan(cvol_context *context, cvol_plan plan, const cvol_array *a,
                      const double cost_ms[])
{
    if (!cvol_plan_name(plan))
        return cvol_fail(context, CVOL_ERROR_ARGUMENT, "plan is %d, must be 0 to %d", (int)plan,
                         CVOL_PLAN_LOW);
    if (plan == CVOL_PLAN_AUTO || isfinite(cost_ms[plan]))
        return CVOL_OK;
    if (a->block)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "the plan %s is for whole arrays; these are in blocks of %d: use blocks "
                         "or auto",
                         cvol_plan_name(plan), a->block);
    if (plan == CVOL_PLAN_BLOCKS)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "the plan blocks is for arrays in blocks; these are whole (block 0)");
    if (plan == CVOL_PLAN_LOW)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "the plan low leaves out terms within a bound, which only the keep rules "
                         "like_inputs, l2 and psnr give");
    if (plan == CVOL_PLAN_SPARSE)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                         "the plan sparse is for dft and dht; these arrays are %s",
                         cvol_transform_name(a->transform));
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED,
                     "the plan %s would hold too many sums; use auto", cvol_plan_name(plan));
}

/* Explains the chosen plan in one sentence. */
static void explain_plan(cvol_multiply_report *report, cvol_plan asked, const cvol_array *a)
{
    const size_t *p = report->points, *n = a->grid.dims;
    const double *cost = report->cost_ms;
    char *out = report->reason;
    const size_t room = sizeof report->reason;
    if (report->sparse_failed)
        snprintf(out, room,
                 "sparse was not verified, or not cheaper; %s is the cheapest exact plan",
                 cvol_plan_name(report->plan));
    else if (a->block)
        snprintf(out, room, "arrays in blocks multiply block by block");
    else if (asked != CVOL_PLAN_AUTO)
        snprintf(out, room, "%s was requested", cvol_plan_name(asked));
    else if (report->plan == CVOL_PLAN_DIRECT)
        snprintf(out, room, "few terms: %.3g ms term by term, %.3g ms on a grid",
                 cost[CVOL_PLAN_DIRECT], fmin(cost[CVOL_PLAN_GRID], cost[CVOL_PLAN_FULL]));
    else if (report->plan == CVOL_PLAN_GRID)
        snprintf(out, room, "low frequencies: %zux%zux%zu points instead of %zux%zux%zu", p[0],
                 p[1], p[2], n[0], n[1], n[2]);
    else if (report->plan == CVOL_PLAN_LOW)
        snprintf(out, room,
                 "few high frequencies are left out: %zux%zux%zu points instead of %zux%zux%zu",
                 p[0], p[1], p[2], n[0], n[1], n[2]);
    else if (report->plan == CVOL_PLAN_SPARSE)
        snprintf(out, room, "scattered terms, few of them kept: %.3g ms, %.3g ms on all points",
                 cost[CVOL_PLAN_SPARSE], cost[CVOL_PLAN_FULL]);
    else
        snprintf(out, room, "the frequencies' sums span the axes: all %zux%zux%zu points", n[0],
                 n[1], n[2]);
}

/* ---- running it ------------------------------------------------------------------------------ */

/* The plan `low`. Under L2 and PSNR the rest of the allowed loss is for truncation. */
static int run_low(cvol_context *context, cvol_array *out, cvol_build_result *result,
                   const cvol_array *a, const cvol_array *b, const cvol_keep *keep,
                   const cvol_low_cut *cut, cvol_multiply_report *report)
{
    cvol_keep rest = *keep;
    const double allowed = cvol_array_allowed(out, keep);
    if (isfinite(allowed) && cut->lost > 0)
        rest = (cvol_keep){.rule = CVOL_KEEP_L2, .value = allowed - cut->lost};
    memcpy(rest.low, keep->low, sizeof rest.low);
    report->left_out = cut->lost;
    out->error_bound.default_loss += keep->rule == CVOL_KEEP_TERMS ? cut->lost : 0;
    return cvol_multiply_low(context, out, result, a, b, cut, &rest, report->points);
}

static int run_exact(cvol_context *context, cvol_array *out, cvol_build_result *result,
                     const cvol_array *a, const cvol_array *b, const cvol_keep *keep,
                     const size_t points[3], const cvol_low_cut *cut, cvol_multiply_report *report)
{
    if (report->plan == CVOL_PLAN_LOW)
        return run_low(context, out, result, a, b, keep, cut, report);
    if (report->plan == CVOL_PLAN_BLOCKS)
        return cvol_blocks_multiply(context, out, result, a, b, keep);
    if (report->plan == CVOL_PLAN_DIRECT)
        return cvol_multiply_direct(context, out, result, a, b, keep);
    const size_t *chosen = report->plan == CVOL_PLAN_FULL ? a->grid.dims : points;
    memcpy(report->points, chosen, sizeof report->points);
    return cvol_multiply_grid(context, out, result, a, b, chosen, keep);
}

static int run(cvol_context *context, cvol_array *out, cvol_build_result *result,
               const cvol_array *a, const cvol_array *b, const cvol_keep *asked,
               const cvol_keep *keep, cvol_plan plan, cvol_multiply_report *report)
{
    size_t points[3] = {0};
    cvol_low_cut cut;
    cvol_multiply_task task;
    find_costs(report, &task, points, a, b, keep);
    int code = find_cost_low(context, report, &cut, task, out, a, b, asked, keep, plan);
    if (!code)
        code = check_plan(context, plan, a, report->cost_ms);
    if (code)
        return code;
    /* The number of terms of the product is unknown in advance. Unless `keep` limits it, sparse is
     * not worth the risk. */
    const int with_sparse = keep->rule == CVOL_KEEP_TERMS;
    report->plan = plan;
    if (plan == CVOL_PLAN_AUTO)
        report->plan = a->block ? CVOL_PLAN_BLOCKS : cheapest(report->cost_ms, with_sparse);
    if (report->plan == CVOL_PLAN_SPARSE) {
        int verified = 0;
        const double limit = plan == CVOL_PLAN_AUTO ? report->cost_ms[cheapest(report->cost_ms, 0)]
                                                    : (double)INFINITY;
        code = cvol_multiply_sparse(context, out, result, a, b, keep, limit, &verified);
        if (code || verified) {
            explain_plan(report, plan, a);
            return code;
        }
        report->sparse_failed = 1;
        report->plan = cheapest(report->cost_ms, 0);
    }
    code = run_exact(context, out, result, a, b, keep, points, &cut, report);
    explain_plan(report, plan, a);
    return code;
}

/* Bounds the L2 norm of an array's samples. */
static double norm_of(const cvol_array *array)
{
    const double most = cvol_error_bound_tighten(&array->error_bound) *
                        sqrt((double)cvol_grid_samples(&array->grid));
    return array->block ? most : sqrt(cvol_spectrum_energy(&array->whole));
}

/* Evaluating a factor rounds its samples; the other factor multiplies that error. */
static double largest_factors(const cvol_array *a, const cvol_array *b)
{
    const double share = 1 / CVOL_SAMPLE_ROUNDING;
    return share * (cvol_array_sample_rounding(a) * cvol_error_bound_tighten(&b->error_bound) +
                    cvol_array_sample_rounding(b) * cvol_error_bound_tighten(&a->error_bound));
}

/* The terms that truncation dropped, and rounding: of each factor, times the other one, and of the
 * product. */
static void set_bound(cvol_array *out, const cvol_array *a, const cvol_array *b,
                      const cvol_build_result *result)
{
    cvol_error_bound *error_bound = &out->error_bound;
    const double factors = norm_of(a) * cvol_error_bound_tighten(&b->error_bound) +
                           norm_of(b) * cvol_error_bound_tighten(&a->error_bound);
    if (result->max_abs >= 0) /* of float products: within their rounding of the exact ones */
        error_bound->max_abs = fmin(error_bound->max_abs, result->max_abs);
    cvol_array_account(out, result, factors);
}

/* A product of stored samples with an offset does not mean that of their values. */
static int multiply_values(cvol_context *context, cvol_array **out, const cvol_array *a,
                           const cvol_array *b, const cvol_keep *keep, cvol_plan plan,
                           cvol_multiply_report *report)
{
    cvol_array *x = NULL, *y = NULL;
    int code = cvol_array_of_values(context, &x, a);
    if (!code && a != b)
        code = cvol_array_of_values(context, &y, b);
    if (!code)
        code = cvol_array_multiply(context, out, x, a != b ? y : x, keep, plan, report);
    cvol_array_free(x);
    cvol_array_free(y);
    return code;
}

int cvol_array_multiply(cvol_context *context, cvol_array **out, const cvol_array *a,
                        const cvol_array *b, const cvol_keep *keep, cvol_plan plan,
                        cvol_multiply_report *report)
{
    *out = NULL;
    cvol_multiply_report own;
    memset(&own, 0, sizeof own);
    int code = cvol_array_compatible(context, a, b);
    if (!code && (fabs(a->grid.value_offset) > 0 || fabs(b->grid.value_offset) > 0))
        return multiply_values(context, out, a, b, keep, plan, report);
    if (!code)
        code = cvol_array_decoded_terms(context, &a, a);
    if (!code)
        code = cvol_array_decoded_terms(context, &b, b);
    if (code)
        return code;
    const cvol_keep wanted = resolve_keep(keep, a, b);
    if (wanted.rule != CVOL_KEEP_LIKE_INPUTS)
        code = cvol_keep_check(context, &wanted, a);
    cvol_array *array = NULL;
    if (!code)
        code = cvol_array_create_like(context, &array, a);
    if (code)
        return code;
    cvol_rescale_set(array, a->grid.value_scale * b->grid.value_scale, 0);
    array->error_bound = cvol_error_bound_multiply(&a->error_bound, &b->error_bound);
    code = cvol_array_check_error_bound(context, array, &array->error_bound, "multiply");
    cvol_build_result result = {.max_abs = -1};
    if (!code)
        code = run(context, array, &result, a, b, keep, &wanted, plan, &own);
    if (!code) {
        result.factors = largest_factors(a, b);
        result.gain = cvol_error_bound_tighten(&a->error_bound) +
                      cvol_error_bound_tighten(&b->error_bound);
        set_bound(array, a, b, &result);
        code = cvol_array_check_error_bound(context, array, &array->error_bound, "multiply");
    }
    if (code) {
        cvol_array_free(array);
        return code;
    }
    cvol_array_derive_figures(array);
    own.terms_a = terms_of(a);
    own.terms_b = terms_of(b);
    own.terms_out = terms_of(array);
    if (report)
        *report = own;
    *out = array;
    return CVOL_OK;
}
