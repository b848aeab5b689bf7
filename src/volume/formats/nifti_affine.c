/* Quaternions of NIfTI headers (nifti1.h, "Method 2", and "Quaternion representation of rotation
 * matrix"):
 *
 *     R = [ aa+bb-cc-dd   2bc-2ad       2bd+2ac     ]
 *         [ 2bc+2ad       aa+cc-bb-dd   2cd-2ab     ]
 *         [ 2bd-2ac       2cd+2ab       aa+dd-cc-bb ]
 *
 * The rotation closest to a matrix X is the orthogonal factor of its polar decomposition, the limit
 * of X <- (g X + X^-T / g) / 2 (Higham, Computing the polar decomposition, 1986). */
#include "volume/formats/nifti_affine.h"

#include <math.h>
#include <string.h>

/* Below this a*a the rotation is by 180 degrees: a is 0. */
#define LEAST_REAL 1e-7

cvol_nifti_affine cvol_nifti_affine_of(const cvol_nifti_rotation *rotation, const double spacing[3],
                                       const double origin[3])
{
    double b = rotation->quaternion[0], c = rotation->quaternion[1], d = rotation->quaternion[2];
    double a = 1 - (b * b + c * c + d * d);
    if (a < LEAST_REAL) {
        const double scale = 1 / sqrt(b * b + c * c + d * d);
        b *= scale, c *= scale, d *= scale;
        a = 0;
    } else {
        a = sqrt(a);
    }
    const double matrix[3][3] = {
        {a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)},
        {2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)},
        {2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - c * c - b * b},
    };
    cvol_nifti_affine affine;
    for (int i = 0; i < 3; i++) {
        for (int axis = 0; axis < 3; axis++)
            affine.step[i][axis] = matrix[i][axis] * spacing[axis];
        if (rotation->handedness < 0)
            affine.step[i][2] = -affine.step[i][2];
        affine.origin[i] = origin[i];
    }
    return affine;
}

static double determinant(double m[3][3])
{
    return m[0][0] * m[1][1] * m[2][2] - m[0][0] * m[2][1] * m[1][2] - m[1][0] * m[0][1] * m[2][2] +
           m[1][0] * m[2][1] * m[0][2] + m[2][0] * m[0][1] * m[1][2] - m[2][0] * m[1][1] * m[0][2];
}

/* out = m^-T: the cofactors over the determinant, which is not 0. */
static void invert_transposed(double out[3][3], double m[3][3])
{
    const double scale = 1 / determinant(m);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            out[i][j] = scale * (m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1]);
        }
}

/* The largest sum of absolute values of a row, times that of a column. */
static double norm(double m[3][3])
{
    double rows = 0, columns = 0;
    for (int i = 0; i < 3; i++) {
        rows = fmax(rows, fabs(m[i][0]) + fabs(m[i][1]) + fabs(m[i][2]));
        columns = fmax(columns, fabs(m[0][i]) + fabs(m[1][i]) + fabs(m[2][i]));
    }
    return sqrt(rows * columns);
}

static void make_orthogonal(double m[3][3])
{
    double change = 1;
    for (int round = 0; round <= 100 && change >= 3e-6; round++) {
        double inverse[3][3];
        invert_transposed(inverse, m);
        const double scale = change > 0.3 ? sqrt(norm(inverse) / norm(m)) : 1;
        change = 0;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                const double next = 0.5 * (scale * m[i][j] + inverse[i][j] / scale);
                change += fabs(next - m[i][j]);
                m[i][j] = next;
            }
    }
}

/* The matrix is a proper rotation. The largest of a, b, c and d is found first, by the diagonal. */
static void put_quaternion(double out[3], double m[3][3])
{
    const double four_aa = 1 + m[0][0] + m[1][1] + m[2][2];
    if (four_aa > 0.5) {
        const double a = 0.5 * sqrt(four_aa);
        out[0] = 0.25 * (m[2][1] - m[1][2]) / a;
        out[1] = 0.25 * (m[0][2] - m[2][0]) / a;
        out[2] = 0.25 * (m[1][0] - m[0][1]) / a;
        return;
    }
    int k = 2;
    double four_kk = 0;
    for (int axis = 0; axis < 3; axis++) {
        const int next = (axis + 1) % 3, last = (axis + 2) % 3;
        four_kk = 1 + m[axis][axis] - (m[next][next] + m[last][last]);
        k = axis;
        if (four_kk > 1)
            break;
    }
    const int next = (k + 1) % 3, last = (k + 2) % 3;
    const double largest = 0.5 * sqrt(four_kk);
    const double a = 0.25 * (m[last][next] - m[next][last]) / largest;
    out[k] = largest;
    out[next] = 0.25 * (m[k][next] + m[next][k]) / largest;
    out[last] = 0.25 * (m[k][last] + m[last][k]) / largest;
    for (int i = 0; i < 3 && a < 0; i++)
        out[i] = -out[i];
}

cvol_nifti_rotation cvol_nifti_rotation_of(const cvol_nifti_affine *affine)
{
    double m[3][3];
    for (int axis = 0; axis < 3; axis++) {
        double squares = 0;
        for (int i = 0; i < 3; i++)
            squares += affine->step[i][axis] * affine->step[i][axis];
        for (int i = 0; i < 3; i++)
            m[i][axis] = affine->step[i][axis] / sqrt(squares);
    }
    make_orthogonal(m);
    cvol_nifti_rotation rotation = {.handedness = determinant(m) > 0 ? 1 : -1};
    for (int i = 0; i < 3 && rotation.handedness < 0; i++)
        m[i][2] = -m[i][2];
    put_quaternion(rotation.quaternion, m);
    return rotation;
}
