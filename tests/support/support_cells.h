/* Operations that work cell by cell, for tests of split and of lapped cells. Each asserts that the
 * result is lapped if its operands are and the operation preserves it. */
#ifndef CVOL_TESTS_SUPPORT_CELLS_H
#define CVOL_TESTS_SUPPORT_CELLS_H

#include "array/core/array.h"

/* Operations on one array do not use b. */
typedef int cell_operation(cvol_context *context, cvol_array **result, const cvol_array *a,
                           const cvol_array *b);
cell_operation cell_add; /* 1.5 a - 0.5 b */
cell_operation cell_multiply;
cell_operation cell_scale; /* 3 - 2 a */
cell_operation cell_one_minus;
cell_operation cell_truncate_all; /* keeps all terms */
cell_operation cell_filter;       /* by a Gaussian */
cell_operation cell_gradient;

#endif
