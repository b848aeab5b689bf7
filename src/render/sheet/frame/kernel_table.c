/* The table of line kernels: kernel_table.h. */
#include "render/sheet/frame/kernel_table.h"

#define ANY_MODE ((cvol_mode)CVOL_ANY)
#define ROW(kernel, mode, order, lit, int16, extras)                        \
    {                                                                       \
#kernel, {mode, order, lit, int16, extras }, CVOL_SIMD_SETS(kernel) \
    }

/*     kernel                            mode                 image lit int16 extras
 *                                                            order              */
static const cvol_kernel_row rows[] = {
    ROW(cvol_sheet_image_order_shade_int16, ANY_MODE, 1, 1, 1, CVOL_ANY),
    ROW(cvol_sheet_image_order_shade, ANY_MODE, 1, 1, 0, CVOL_ANY),
    ROW(cvol_sheet_image_order_extra, ANY_MODE, 1, 0, CVOL_ANY, 1),
    ROW(cvol_sheet_image_order_int16, ANY_MODE, 1, 0, 1, 0),
    ROW(cvol_sheet_image_order, ANY_MODE, 1, 0, 0, 0),
    ROW(cvol_sheet_max_int16, CVOL_MODE_MIP, 0, 0, 1, CVOL_ANY),
    ROW(cvol_sheet_min_int16, CVOL_MODE_MIN, 0, 0, 1, CVOL_ANY),
    ROW(cvol_sheet_composite_int16, CVOL_MODE_COMPOSITE, 0, 0, 1, CVOL_ANY),
    ROW(cvol_sheet_shade, ANY_MODE, 0, 1, 0, 0),
    ROW(cvol_sheet_composite, CVOL_MODE_COMPOSITE, 0, 0, 0, 0),
    ROW(cvol_sheet_shade_extra, ANY_MODE, 0, 1, 0, CVOL_ANY),
    ROW(cvol_sheet_composite_extra, CVOL_MODE_COMPOSITE, 0, 0, 0, CVOL_ANY),
    ROW(cvol_sheet_max, CVOL_MODE_MIP, 0, 0, 0, CVOL_ANY),
    ROW(cvol_sheet_min, CVOL_MODE_MIN, 0, 0, 0, CVOL_ANY),
    ROW(cvol_sheet_sum, CVOL_MODE_XRAY, 0, 0, 0, CVOL_ANY),
};

const cvol_kernel_row *cvol_sheet_kernels(size_t *count)
{
    *count = sizeof rows / sizeof *rows;
    return rows;
}

static int fits(int asked, int row)
{
    return row == CVOL_ANY || asked == row;
}

cvol_sheet_kernel *cvol_sheet_kernel_find(const cvol_kernel_key *key, cvol_cpu cpu)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const cvol_kernel_key *row = &rows[i].key;
        if (fits((int)key->mode, (int)row->mode) &&
            fits(key->is_image_order, row->is_image_order) && fits(key->is_lit, row->is_lit) &&
            fits(key->is_int16, row->is_int16) && fits(key->has_extras, row->has_extras))
            return rows[i].sets[cpu];
    }
    return NULL;
}
