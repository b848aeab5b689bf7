/* Float samples, and their rises, at a part of a group's pixels along lines that cross rows
 * obliquely (line_slanted.h). Each pixel loads four samples of four rows, from one before to two
 * behind its own place; the results of all pixels are transposed into vectors.
 *
 * Only kernel files include this file, behind line.h. */
#ifndef CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_FLOAT_H
#define CVOL_RENDER_SHEET_KERNELS_LIT_IMAGE_ORDER_SHADE_FLOAT_H

/* Not inlined, since it is long and used in several places. */
#define OUT_OF_LINE static __attribute__((noinline))

/* The positions of the pixels. */
typedef struct group_place {
    const float *from;    /* sample 0 of the first existing row of the slice */
    cvol_vi lane, row;    /* the sample before each pixel, along lanes and along rows */
    cvol_vi at[4];        /* distance of sample lane - 1 of rows row - 1 .. row + 2 from `from` */
    cvol_vf right, below; /* distance of each pixel from its sample */
} group_place;

CVOL_INLINE void begin_places(line_job *job)
{
    (void)job; /* nothing to prepare */
}

/* Samples beyond the existing ones are don't-care: such pixels are not drawn. */
CVOL_INLINE void place_group(group_place *out, const line_job *job, const sheet_line *sheet,
                             int group, int part)
{
    const cvol_layer *layer = job->layer;
    const image_order_part of = place_part(job, sheet, group * CVOL_GROUP + part * CVOL_LANES);
    const double x0 = floor(of.at[0]), y0 = floor(of.at[1]);
    const cvol_vf u = (float)(of.at[0] - x0) + spread_pixels((float)of.right[0], (float)of.down[0]),
                  v = (float)(of.at[1] - y0) + spread_pixels((float)of.right[1], (float)of.down[1]);
    const float bias = 1024; /* samples may lie before the first pixel's */
    const cvol_vi column = cvol_to_int(u + bias) - (int)bias,
                  line = cvol_to_int(v + bias) - (int)bias;
    out->right = u - cvol_to_float(column);
    out->below = v - cvol_to_float(line);
    out->lane = column + (int)x0;
    out->row = line + (int)y0;
    out->from = sheet->origin + layer->from_row * layer->row_stride;
    const cvol_vi lane = cvol_clamp_int(out->lane - 1, layer->from_lane, layer->to_lane - 3);
    for (int k = 0; k < 4; k++) {
        const cvol_vi row = cvol_clamp_int(out->row + (k - 1), layer->from_row, layer->to_row);
        out->at[k] = (row - layer->from_row) * (int)layer->row_stride + lane;
    }
}

/* ---- values ---------------------------------------------------------------------------------- */

/* Samples, `offset` behind the slice's. */
OUT_OF_LINE cvol_vf value_of_group(const line_job *job, const group_place *at, ptrdiff_t offset)
{
    const float *from = at->from + offset + 1;
    cvol_four around[CVOL_LANES];
    cvol_vf v[4];
    (void)job;
    for (int i = 0; i < CVOL_LANES; i++)
        around[i] = cvol_load_pairs(from + at->at[1][i], from + at->at[2][i]);
    cvol_transpose_fours(v, around);
    const cvol_vf near = v[0] + at->right * (v[1] - v[0]), far = v[2] + at->right * (v[3] - v[2]);
    return near + at->below * (far - near);
}

/* ---- rises ----------------------------------------------------------------------------------- */

/* One pixel's rows, each of four samples, of the slice itself or of the mean of two slices; and the
 * difference of the slices behind and before, of its near and its far row. */
typedef struct pixel_rows {
    cvol_four row[4], across[2];
} pixel_rows;

/* What the pixels need, by rows. */
typedef struct mixed_rows {
    cvol_four along[CVOL_LANES];  /* the row through the pixel */
    cvol_four across[CVOL_LANES]; /* of its middle two samples: rises along rows, along slices */
} mixed_rows;

CVOL_INLINE void mix_rows(mixed_rows *out, int i, const pixel_rows *of, float below)
{
    const cvol_four *row = of->row;
    out->along[i] = row[1] + below * (row[2] - row[1]);
    const cvol_four near = row[2] - row[0], far = row[3] - row[1];
    out->across[i] = cvol_middle_of_fours(near + below * (far - near),
                                          of->across[0] + below * (of->across[1] - of->across[0]));
}

/* Returns the values; their rises along lanes, rows and slices from one before to one behind. */
CVOL_INLINE cvol_vf finish_rises(cvol_vf out[3], const mixed_rows *of, cvol_vf right)
{
    cvol_vf along[4], across[4];
    cvol_transpose_fours(along, of->along);
    cvol_transpose_fours(across, of->across);
    const cvol_vf left = along[2] - along[0];
    out[0] = left + right * (along[3] - along[1] - left);
    out[1] = across[0] + right * (across[1] - across[0]);
    out[2] = across[2] + right * (across[3] - across[2]);
    return along[1] + right * (along[2] - along[1]);
}

/* For the slices `before` and `behind` in memory. */
OUT_OF_LINE void rise_of_group(cvol_vf out[3], const line_job *job, const group_place *at,
                               ptrdiff_t before, ptrdiff_t behind)
{
    mixed_rows mixed;
    (void)job;
    for (int i = 0; i < CVOL_LANES; i++) {
        pixel_rows rows;
        for (int k = 0; k < 4; k++)
            rows.row[k] = cvol_load_four(at->from + at->at[k][i]);
        for (int k = 0; k < 2; k++) {
            const float *from = at->from + at->at[k + 1][i];
            rows.across[k] = cvol_load_four(from + behind) - cvol_load_four(from + before);
        }
        mix_rows(&mixed, i, &rows, at->below[i]);
    }
    finish_rises(out, &mixed, at->right);
}

/* The midpoint between a slice and the one before: four consecutive slices. */
typedef struct four_sheets {
    ptrdiff_t first, before, behind; /* the slice itself is the third */
} four_sheets;

/* The value there, and its rises: of the mean of the two slices. */
OUT_OF_LINE cvol_vf midpoint_of_group(cvol_vf rise[3], const line_job *job, const group_place *at,
                                      const four_sheets *of)
{
    mixed_rows mixed;
    (void)job;
    for (int i = 0; i < CVOL_LANES; i++) {
        pixel_rows rows;
        for (int k = 0; k < 4; k++) {
            const float *from = at->from + at->at[k][i];
            const cvol_four second = cvol_load_four(from + of->before),
                            third = cvol_load_four(from);
            rows.row[k] = 0.5f * (second + third);
            if (k == 1 || k == 2)
                rows.across[k - 1] = 0.5f * (third + cvol_load_four(from + of->behind) - second -
                                             cvol_load_four(from + of->first));
        }
        mix_rows(&mixed, i, &rows, at->below[i]);
    }
    return finish_rises(rise, &mixed, at->right);
}

/* ---- windows --------------------------------------------------------------------------------- */

/* Finds the pixels with an invisible window, and its levels. */
CVOL_COLD cvol_vi find_unseen_of_group(cvol_vf *levels, const cvol_layer *layer,
                                       const cvol_windows *windows, const group_place *at)
{
#if defined(__AVX512F__)
    __m512 found;
    const __mmask16 unseen = find_unseen(&found, layer, windows, (__m512i)at->lane,
                                         (__m512i)at->row);
    *levels = (cvol_vf)found;
    return (cvol_vi)_mm512_movm_epi32(unseen);
#else
    return find_unseen(levels, layer, windows, at->lane, at->row);
#endif
}

#endif
