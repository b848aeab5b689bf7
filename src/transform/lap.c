/* The filter across faces of cells: the faces of a box, the matrices, the reference, and the choice
 * of kernel. */
#include "transform/lap.h"

#include <math.h>

#include "base/cpu.h"
#include "base/elementary.h"
#include "transform/lap_faces.h"

#define PI 3.14159265358979323846

const float cvol_lap_pre_matrix[4][4] = {
    {1.0972387912921927f, -0.1352990250365492f, 0.1352990250365492f, -0.0972387912921927f},
    {0.3266407412190941f, 1.0179824574016391f, -0.0179824574016391f, -0.3266407412190941f},
    {-0.3266407412190941f, -0.0179824574016391f, 1.0179824574016391f, 0.3266407412190941f},
    {-0.0972387912921927f, 0.1352990250365492f, -0.1352990250365492f, 1.0972387912921927f},
};
const float cvol_lap_post_matrix[4][4] = {
    {0.8662689081643710f, 0.0956708580912724f, -0.0956708580912724f, 0.1337310918356290f},
    {-0.2309698831278217f, 0.9223115993103666f, 0.0776884006896334f, 0.2309698831278217f},
    {0.2309698831278217f, 0.0776884006896334f, 0.9223115993103666f, -0.2309698831278217f},
    {0.1337310918356290f, -0.0956708580912724f, 0.0956708580912724f, 0.8662689081643710f},
};

/* The box's faces across an axis, and the lines that cross them. Lines that are adjacent in memory,
 * if there are any, come first. */
static cvol_lap_faces find_faces(const cvol_lap_box *box, int axis)
{
    const int64_t begin = box->begin[axis], grid = box->grid;
    int64_t end = begin + box->size[axis], face = grid;
    if (end > box->shape[axis])
        end = box->shape[axis];
    if (begin + 2 > face)
        face = (begin + 2 + grid - 1) / grid * grid;
    cvol_lap_faces faces = {.first = (face - 2 - begin) * box->stride[axis],
                            .stride = box->stride[axis],
                            .face_stride = grid * box->stride[axis]};
    if (face + 2 <= end)
        faces.count = (end - 2 - face) / grid + 1;
    int near = (axis + 1) % 3, far = (axis + 2) % 3;
    if (box->stride[near] != 1) {
        int other = near;
        near = far;
        far = other;
    }
    faces.lines[0] = box->size[near];
    faces.lines[1] = box->size[far];
    faces.line_stride[0] = box->stride[near];
    faces.line_stride[1] = box->stride[far];
    return faces;
}

CVOL_SIMD_DECLARE(void, cvol_lap_filter,
                  (float *samples, const cvol_lap_faces *faces, const float h[4]));

static void filter(float *samples, const cvol_lap_box *box, int axis, const float h[4])
{
    cvol_lap_faces faces = find_faces(box, axis);
    if (faces.count > 0)
        CVOL_SIMD_CHOOSE(cvol_lap_filter)(samples + faces.first, &faces, h);
}

void cvol_lap_pre(float *samples, const cvol_lap_box *box, int axis)
{
    static const float h[4] = CVOL_LAP_PRE_H;
    filter(samples, box, axis, h);
}

void cvol_lap_post(float *samples, const cvol_lap_box *box, int axis)
{
    static const float h[4] = CVOL_LAP_POST_H;
    filter(samples, box, axis, h);
}

/* V = J C2^T diag(s, 1) C4 J, or its inverse J C4^T diag(1/s, 1) C2 J. */
static void find_v(double V[2][2], int inverse)
{
    double C2[2][2], C4[2][2];
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 2; i++) {
            C2[k][i] = (k ? 1.0 : sqrt(0.5)) * cvol_cos(PI * k * (i + 0.5) / 2);
            C4[k][i] = cvol_cos(PI * (k + 0.5) * (i + 0.5) / 2);
        }
    const double s = sqrt(2.0);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++)
            if (inverse)
                V[i][j] = C4[0][1 - i] / s * C2[0][1 - j] + C4[1][1 - i] * C2[1][1 - j];
            else
                V[i][j] = C2[0][1 - i] * s * C4[0][1 - j] + C2[1][1 - i] * C4[1][1 - j];
}

static void filter_reference(float *samples, const cvol_lap_box *box, int axis, int inverse)
{
    double V[2][2];
    find_v(V, inverse);
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    const int64_t stride = box->stride[axis];
    for (int64_t e = box->grid; e + 2 <= box->shape[axis]; e += box->grid) {
        if (e - 2 < box->begin[axis] || e + 2 > box->begin[axis] + box->size[axis])
            continue;
        for (int64_t j = 0; j < box->size[last]; j++)
            for (int64_t i = 0; i < box->size[next]; i++) {
                float *a = samples + (e - 2 - box->begin[axis]) * stride + i * box->stride[next] +
                           j * box->stride[last];
                double even[2], odd[2];
                for (int k = 0; k < 2; k++) {
                    even[k] = (double)a[(1 - k) * stride] + (double)a[(2 + k) * stride];
                    odd[k] = (double)a[(1 - k) * stride] - (double)a[(2 + k) * stride];
                }
                for (int k = 0; k < 2; k++) {
                    double mixed = V[k][0] * odd[0] + V[k][1] * odd[1];
                    a[(1 - k) * stride] = (float)((even[k] + mixed) / 2);
                    a[(2 + k) * stride] = (float)((even[k] - mixed) / 2);
                }
            }
    }
}

void cvol_lap_pre_reference(float *samples, const cvol_lap_box *box, int axis)
{
    filter_reference(samples, box, axis, 0);
}

void cvol_lap_post_reference(float *samples, const cvol_lap_box *box, int axis)
{
    filter_reference(samples, box, axis, 1);
}
