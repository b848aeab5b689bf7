/* Sweeps (sweep.h). */
#include "render/light/sweep.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/memory.h"

/* Two slices of depths, with a border of empty cells. */
#define BORDER 2

typedef struct job {
    const cvol_coarse *coarse;
    const float *extinction;
    int axis, across[2];          /* the sweep's, those of its slices: rows run along across[0] */
    size_t n[2], stride[2], step; /* cells of a slice, and their distances in memory */
    ptrdiff_t shift[2];           /* whole cells from p to q, in a slice */
    float weights[2][3];          /* of q's cell and its neighbours */
    float length, keep;
    size_t width; /* of a slice with its border */
} job;

static void set_weights(float weights[3], double fraction, double blur)
{
    const double below = 0.5 * (0.5 - fraction) * (0.5 - fraction),
                 above = 0.5 * (0.5 + fraction) * (0.5 + fraction), rest = 1 - below - above;
    weights[0] = (float)(below + blur * (0.25 - below));
    weights[1] = (float)(rest + blur * (0.5 - rest));
    weights[2] = (float)(above + blur * (0.25 - above));
}

static void prepare(job *j, const cvol_sweep *sweep)
{
    const size_t *dims = j->coarse->dims, strides[3] = {1, dims[0], dims[0] * dims[1]};
    double cells[3], square = 0;
    for (int a = 0; a < 3; a++)
        cells[a] = sweep->way[a] / j->coarse->length[a];
    for (int a = 1; a < 3; a++)
        j->axis = fabs(cells[a]) > fabs(cells[j->axis]) ? a : j->axis;
    j->across[0] = j->axis == 0 ? 1 : 0;
    j->across[1] = 3 - j->axis - j->across[0];
    for (int k = 0; k < 2; k++) {
        const double by = cells[j->across[k]] / fabs(cells[j->axis]);
        j->n[k] = dims[j->across[k]];
        j->stride[k] = strides[j->across[k]];
        j->shift[k] = lround(by);
        set_weights(j->weights[k], by - (double)j->shift[k], sweep->blur);
    }
    j->step = strides[j->axis];
    for (int a = 0; a < 3; a++) {
        const double part = cells[a] / cells[j->axis] * j->coarse->length[a];
        square += part * part;
    }
    j->length = (float)sqrt(square);
    j->keep = (float)sweep->keep;
    j->width = j->n[0] + 2 * BORDER;
}

/* A row of depths from those of the slice before; `extinction` of that slice is already in them. */
static void step_row(float *out, const job *j, const float *before, size_t row)
{
    const float *w = j->weights[0], *v = j->weights[1];
    for (size_t i = 0; i < j->n[0]; i++)
        out[i] = 0;
    for (int k = -1; k <= 1; k++) {
        const ptrdiff_t line = (ptrdiff_t)row + j->shift[1] + k;
        if (line < 0 || line >= (ptrdiff_t)j->n[1])
            continue;
        const float *from = before + (size_t)(line + BORDER) * j->width + BORDER + j->shift[0];
        for (size_t i = 0; i < j->n[0]; i++)
            out[i] += v[k + 1] *
                      (w[0] * from[(ptrdiff_t)i - 1] + w[1] * from[i] + w[2] * from[i + 1]);
    }
}

/* Adds the extinction of a slice to its row of depths. */
static void absorb_row(float *out, const job *j, const float *depths, size_t first)
{
    for (size_t i = 0; i < j->n[0]; i++)
        out[i] = j->keep * (depths[i] + j->length * j->extinction[first + i * j->stride[0]]);
}

int cvol_sweep_run(cvol_context *context, const cvol_coarse *coarse, const float *extinction,
                   const cvol_sweep *sweep, cvol_sweep_fn use, void *user)
{
    job j = {.coarse = coarse, .extinction = extinction};
    prepare(&j, sweep);
    const size_t slices = coarse->dims[j.axis], plane = j.width * (j.n[1] + 2 * BORDER);
    float *memory = cvol_allocate_zero(2 * plane + j.n[0] * j.n[1], sizeof *memory);
    if (!memory)
        return cvol_fail_memory(context, (2 * plane + j.n[0] * j.n[1]) * sizeof *memory,
                                "slices of light");
    float *depths = memory + 2 * plane;
    for (size_t s = 0; s < slices; s++) {
        const size_t slice = sweep->way[j.axis] > 0 ? slices - 1 - s : s;
        const float *before = memory + (s + 1) % 2 * plane;
        float *now = memory + s % 2 * plane;
#pragma omp parallel for num_threads(cvol_context_threads(context)) if (j.n[0] * j.n[1] > 4096)
        for (size_t row = 0; row < j.n[1]; row++) {
            const size_t first = slice * j.step + row * j.stride[1];
            float *out = depths + row * j.n[0];
            step_row(out, &j, before, row);
            use(user, out, first, j.n[0], j.stride[0]);
            absorb_row(now + (row + BORDER) * j.width + BORDER, &j, out, first);
        }
    }
    free(memory);
    return CVOL_OK;
}
