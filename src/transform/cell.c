/* DCTs of split cells: the sub-blocks of a split, the reference, the matrices, the choice of
 * kernel. */
#include "transform/cell.h"

#include <math.h>
#include <pthread.h>
#include <string.h>

#include "base/cpu.h"
#include "base/elementary.h"
#include "transform/cell_bases.h"

#define PI 3.14159265358979323846

/* Filled once and then read only. */
static cvol_cell_bases bases __attribute__((aligned(64)));
static pthread_once_t bases_once = PTHREAD_ONCE_INIT;

static double basis_value(int f, int x, int side)
{
    return sqrt((f ? 2.0 : 1.0) / side) * cvol_cos(PI * f * (x + 0.5) / side);
}

int cvol_cell_valid_split(uint16_t split)
{
    return split == CVOL_CELL_WHOLE || ((split & 1) && split <= CVOL_CELL_FOURS);
}

/* The sub-blocks of one octant, of side 8 or 4. */
static int list_octant(cvol_sub_block *parts, const int half[3], int side)
{
    int count = 0, quarters = 8 / side;
    for (int i = 0; i < quarters * quarters * quarters; i++) {
        const int quarter[3] = {i % quarters, i / quarters % quarters, i / quarters / quarters};
        cvol_sub_block *part = &parts[count++];
        part->side = side;
        for (int a = 0; a < 3; a++) {
            part->begin[a] = 8 * half[a] + 4 * quarter[a];
            part->first[a] = half[a] + 2 * quarter[a];
        }
    }
    return count;
}

int cvol_cell_list_sub_blocks(cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX], uint16_t split)
{
    if (!(split & 1)) {
        parts[0] = (cvol_sub_block){.side = CVOL_CELL};
        return 1;
    }
    int count = 0;
    for (int i = 0; i < 8; i++) {
        const int half[3] = {i & 1, i >> 1 & 1, i >> 2};
        count += list_octant(parts + count, half, split >> (1 + i) & 1 ? 4 : 8);
    }
    return count;
}

/* The place in the cell of a sub-block's sample, or frequency, i. */
static int place_of(const cvol_sub_block *part, int i, int axis, int frequency)
{
    if (frequency)
        return part->first[axis] + i * (CVOL_CELL / part->side);
    return part->begin[axis] + i;
}

/* out[i, j, k] = sum over p, q, r of the matrices' elements times in[p, q, r]. */
static void transform_part(float *out, const float *in, const cvol_sub_block *part, int inverse)
{
    const int M = part->side;
    double matrix[CVOL_CELL][CVOL_CELL];
    int from[3][CVOL_CELL], to[3][CVOL_CELL];
    for (int i = 0; i < M; i++)
        for (int p = 0; p < M; p++)
            matrix[i][p] = inverse ? basis_value(p, i, M) : basis_value(i, p, M);
    for (int a = 0, stride = 1; a < 3; a++, stride *= CVOL_CELL)
        for (int i = 0; i < M; i++) {
            from[a][i] = stride * place_of(part, i, a, inverse);
            to[a][i] = stride * place_of(part, i, a, !inverse);
        }
    for (int k = 0; k < M; k++)
        for (int j = 0; j < M; j++)
            for (int i = 0; i < M; i++) {
                double sum = 0;
                for (int r = 0; r < M; r++)
                    for (int q = 0; q < M; q++) {
                        double line = 0;
                        for (int p = 0; p < M; p++)
                            line += matrix[i][p] * (double)in[from[0][p] + from[1][q] + from[2][r]];
                        sum += matrix[k][r] * matrix[j][q] * line;
                    }
                out[to[0][i] + to[1][j] + to[2][k]] = (float)sum;
            }
}

static void transform_reference(float *out, const float *in, uint16_t split, int inverse)
{
    cvol_sub_block parts[CVOL_SUB_BLOCKS_MAX];
    int count = cvol_cell_list_sub_blocks(parts, split);
    for (int i = 0; i < count; i++)
        transform_part(out, in, &parts[i], inverse);
}

void cvol_cell_forward_reference(float *out, const float *in, uint16_t split)
{
    transform_reference(out, in, split, 0);
}

void cvol_cell_inverse_reference(float *out, const float *in, uint16_t split)
{
    transform_reference(out, in, split, 1);
}

static void fill_square(float *basis, int side)
{
    for (int f = 0; f < side; f++)
        for (int x = 0; x < side; x++)
            basis[f * side + x] = (float)basis_value(f, x, side);
}

/* The value of place u = 2 g + c at sample x of its half (of the folded cell if it is whole). */
static double lane_value(int way, int c, int g, int x)
{
    if (way == CVOL_CELL_BY_16)
        return basis_value(2 * g + c, x, 16);
    if (way == CVOL_CELL_BY_8)
        return basis_value(g, x, 8);
    return g % 2 == x / 4 ? basis_value(g / 2, x % 4, 4) : 0;
}

static void fill_bases(void)
{
    for (int way = CVOL_CELL_BY_16; way <= CVOL_CELL_BY_4; way++)
        for (int c = 0; c < 2; c++)
            for (int g = 0; g < 8; g++)
                for (int x = 0; x < 8; x++) {
                    bases.lanes[way][c][g][x] = (float)lane_value(way, c, g, x);
                    bases.columns[way][c][x][g] = (float)lane_value(way, c, g, x);
                }
    fill_square(bases.of_4, 4);
    fill_square(bases.of_8, 8);
    fill_square(bases.of_16, 16);
}

CVOL_SIMD_DECLARE(void, cvol_cell_forward_by,
                  (float *out, const float *in, int way, const cvol_cell_bases *with));
CVOL_SIMD_DECLARE(void, cvol_cell_inverse_box,
                  (float *out, const float *in, uint16_t split, const int box[3],
                   const cvol_cell_bases *with));

/* Copies the split octants from the transform in which all octants are split. */
static void pick_fours(float *out, const float *fours, uint16_t split)
{
    for (int row = 0; row < CVOL_CELL * CVOL_CELL; row++) {
        const int cy = row & 1, cz = row >> 4 & 1;
        for (int c = 0; c < 2; c++)
            if (cvol_cell_octant_transform(split, c, cy, cz) == CVOL_CELL_BY_4)
                for (int u = c; u < CVOL_CELL; u += 2)
                    out[row * CVOL_CELL + u] = fours[row * CVOL_CELL + u];
    }
}

void cvol_cell_forward(float *out, const float *in, uint16_t split)
{
    pthread_once(&bases_once, fill_bases);
    const int way = !(split & 1)               ? CVOL_CELL_BY_16
                    : split == CVOL_CELL_FOURS ? CVOL_CELL_BY_4
                                               : CVOL_CELL_BY_8;
    CVOL_SIMD_CHOOSE(cvol_cell_forward_by)(out, in, way, &bases);
    if (way == CVOL_CELL_BY_8 && split != CVOL_CELL_OCTANTS) {
        float fours[CVOL_CELL_SAMPLES] __attribute__((aligned(64)));
        CVOL_SIMD_CHOOSE(cvol_cell_forward_by)(fours, in, CVOL_CELL_BY_4, &bases);
        pick_fours(out, fours, split);
    }
}

void cvol_cell_inverse(float *out, const float *in, uint16_t split, const int box[3])
{
    pthread_once(&bases_once, fill_bases);
    CVOL_SIMD_CHOOSE(cvol_cell_inverse_box)(out, in, split, box, &bases);
}
