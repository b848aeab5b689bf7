/* Small dense linear algebra in double precision, for interpolation. Matrices are columns, each of
 * `rows` numbers. */
#ifndef CVOL_ARRAY_EVALUATE_SMALL_MATRIX_H
#define CVOL_ARRAY_EVALUATE_SMALL_MATRIX_H

#include <complex.h>
#include <stddef.h>

/* The largest matrix for the eigenvalue routine. */
#define CVOL_DENSE_MAX 128

/* Rotates the columns of A (rows >= cols) until they are orthogonal (one-sided Jacobi, Hestenes
 * 1958) and sorts them, longest first: A = U S V^T becomes U S. lengths[cols]: the singular values.
 */
void cvol_dense_orthogonalise(double *a, double *lengths, size_t rows, size_t cols);

/* Least squares by Householder's QR: the x that minimise |A x - b| for each of `count` columns b
 * (rows numbers each), written to the first cols numbers of b. A is overwritten. Directions that A
 * does not determine (within 1e-14) become 0. */
void cvol_dense_least_squares(double *a, double *b, size_t rows, size_t cols, size_t count);

/* The eigenvalues of a square matrix, by QR steps with Wilkinson's shifts on its Hessenberg form
 * (Golub and Van Loan, 7.4 and 7.5). A is overwritten. Returns 0 if they did not converge. */
int cvol_dense_eigenvalues(double complex *values, double complex *a, size_t n);

#endif
