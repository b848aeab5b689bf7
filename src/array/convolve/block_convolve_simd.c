/* A block of a kernel's result: see block_convolve.h. x first, where each term is one scaled row of
 * a matrix; then y, then z, on whole vectors of frequencies u. */
#include "array/convolve/block_convolve.h"

#include "base/cpu.h"
#include "base/vector.h"

void CVOL_SIMD(cvol_block_convolve)(float *out, const cvol_block *const near[27],
                                    const cvol_convolve_part *parts, int part_count, int block_log2,
                                    cvol_convolve_work *work);

/* The rows v of each sheet w of frequencies that have terms: those below count[w], w < sheets. */
typedef struct row_counts {
    int sheets;
    uint8_t count[CVOL_BLOCK_MAX];
} row_counts;

/* Along x: lanes[w][v][.] = sum over dx and terms of value H_dx[u][.], for the rows of *rows. */
CVOL_INLINE void gather_terms(float *lanes, row_counts *rows, const cvol_block *const near[3],
                              const cvol_face_matrices *x, int block_log2)
{
    const int B = 1 << block_log2, width = B < 16 ? 16 : B;
    rows->sheets = 0;
    memset(rows->count, 0, sizeof rows->count);
    for (int d = 0; d < 3; d++) {
        if (!near[d] || !x->of[d])
            continue;
        rows->sheets = near[d]->low[2] > rows->sheets ? near[d]->low[2] : rows->sheets;
        const uint32_t *words = near[d]->terms, *end = words + near[d]->words;
        while (words < end) {
            uint32_t place;
            const float value = (float)cvol_term_unpack(&words, &place,
                                                        cvol_place_bits(block_log2));
            const float *row = x->of[d] + (place & (uint32_t)(B - 1)) * (unsigned)width;
            const uint32_t v = place >> block_log2 & (uint32_t)(B - 1), w = place >> 2 * block_log2;
            float *sheet = lanes + w * (unsigned)(B * width), *line = sheet + v * (unsigned)width;
            if (v >= rows->count[w]) {
                memset(sheet + rows->count[w] * width, 0,
                       sizeof(float) * (v + 1 - rows->count[w]) * (size_t)width);
                rows->count[w] = (uint8_t)(v + 1);
            }
            for (int part = 0; part < width; part += CVOL_LANES)
                cvol_store(line + part, cvol_load(line + part) + value * cvol_load(row + part));
        }
    }
}

/* out[i] += scale sum_{v < count} matrix[i][v] in[v], i < B; vectors lie `stride` floats apart. */
CVOL_INLINE void add_matrix(float *out, const float *in, ptrdiff_t out_stride, ptrdiff_t in_stride,
                            const float *matrix, int count, int B, float scale)
{
    for (int i = 0; i < B; i += 4) {
        cvol_vf sum[4] = {{0}, {0}, {0}, {0}};
        for (int v = 0; v < count; v++) {
            cvol_vf line = cvol_load(in + v * in_stride);
            for (int t = 0; t < 4; t++)
                sum[t] += matrix[(i + t) * B + v] * line;
        }
        for (int t = 0; t < 4; t++) {
            float *to = out + (i + t) * out_stride;
            cvol_store(to, cvol_load(to) + scale * sum[t]);
        }
    }
}

/* Along y: rows[w][v'][.] summed over dy; *low_z: the frequencies w in use. */
CVOL_INLINE void sum_rows(float *rows, int *low_z, float *lanes, const cvol_block *const near[9],
                          const cvol_convolve_part *part, int block_log2)
{
    const int B = 1 << block_log2, width = B < 16 ? 16 : B;
    *low_z = 0;
    for (int dy = 0; dy < 3; dy++) {
        row_counts counts;
        if (!part->y.of[dy])
            continue;
        gather_terms(lanes, &counts, near + 3 * dy, &part->x, block_log2);
        for (; *low_z < counts.sheets; ++*low_z)
            memset(rows + *low_z * B * width, 0, sizeof(float) * (size_t)(B * width));
        for (int w = 0; w < counts.sheets; w++)
            for (int lane = 0; lane < width && counts.count[w]; lane += CVOL_LANES)
                add_matrix(rows + w * B * width + lane, lanes + w * B * width + lane, width, width,
                           part->y.of[dy], counts.count[w], B, 1);
    }
}

CVOL_INLINE void convolve(float *out, const cvol_block *const near[27],
                          const cvol_convolve_part *parts, int part_count, int block_log2,
                          cvol_convolve_work *work)
{
    const int B = 1 << block_log2, width = B < 16 ? 16 : B;
    memset(work->sum, 0, sizeof(float) * (size_t)(B * B * width));
    for (int p = 0; p < part_count; p++)
        for (int dz = 0; dz < 3; dz++) {
            int low_z;
            if (!parts[p].z.of[dz])
                continue;
            sum_rows(work->rows, &low_z, work->lanes, near + 9 * dz, &parts[p], block_log2);
            if (low_z)
                for (int lane = 0; lane < B * width; lane += CVOL_LANES)
                    add_matrix(work->sum + lane, work->rows + lane, (ptrdiff_t)B * width,
                               (ptrdiff_t)B * width, parts[p].z.of[dz], low_z, B, parts[p].weight);
        }
    for (int row = 0; row < B * B; row++)
        memcpy(out + row * B, work->sum + row * width, sizeof(float) * (size_t)B);
}

void CVOL_SIMD(cvol_block_convolve)(float *out, const cvol_block *const near[27],
                                    const cvol_convolve_part *parts, int part_count, int block_log2,
                                    cvol_convolve_work *work)
{
    if (block_log2 == 4)
        convolve(out, near, parts, part_count, 4, work);
    else if (block_log2 == 3)
        convolve(out, near, parts, part_count, 3, work);
    else
        convolve(out, near, parts, part_count, 5, work);
}
