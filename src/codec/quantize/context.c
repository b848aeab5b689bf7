/* Predicts sub-blocks and their contexts from neighbours. */
#include "codec/quantize/context.h"

#include "codec/quantize/coding.h"
#include "codec/quantize/quantize.h"

static int unit_of(const int at[3])
{
    return at[0] + CVOL_BRICK_UNITS * (at[1] + CVOL_BRICK_UNITS * at[2]);
}

static int64_t divide_down(int64_t a, int64_t b)
{
    return a / b - (a % b < 0);
}

static int length_of(uint64_t value, int most)
{
    int length = 0;
    for (; value && length < most; value >>= 1)
        length++;
    return length;
}

cvol_sub_block_context cvol_sub_block_context_of(const cvol_brick_context *brick, const int at[3],
                                                 const cvol_scan *scan)
{
    static const int strides[3] = {1, CVOL_BRICK_UNITS, CVOL_BRICK_UNITS * CVOL_BRICK_UNITS};
    const int unit = unit_of(at);
    const int size_class = scan->size_class;
    const int64_t weight = scan->weight;
    int64_t sum = 0, least = INT64_MAX, most = INT64_MIN;
    int count = 0, lengths = 0;
    for (int a = 0; a < 3; a++) {
        if (!at[a])
            continue;
        const int64_t mean = brick->mean[unit - strides[a]];
        const int length = brick->length[unit - strides[a]];
        const int scaled = length - 3 * (CVOL_SUB_BLOCK_SIZES - 1 - size_class);
        lengths += length == 0 ? 0 : scaled < 1 ? 1 : scaled;
        sum += mean;
        least = mean < least ? mean : least;
        most = mean > most ? mean : most;
        count++;
    }
    cvol_sub_block_context context = {0, CVOL_ROW_DC + size_class * CVOL_SPREADS, 0};
    if (!count)
        return context;
    const int64_t prediction = divide_down(2 * sum + count * weight, 2 * count * weight);
    const int64_t limit = CVOL_VALUE_LIMIT - 1; /* differences then fit into 31 bits */
    context.prediction = prediction < -limit ? -limit : prediction > limit ? limit : prediction;
    context.around = 1 + (lengths + count / 2) / count;
    context.dc_row += count == 1
                          ? 1
                          : 2 + length_of((uint64_t)((most - least) / weight), CVOL_SPREADS - 3);
    return context;
}

void cvol_sub_block_note(cvol_brick_context *brick, const int at[3], const cvol_scan *scan,
                         int32_t dc, int length)
{
    const int size_class = scan->size_class, side = 1 << size_class;
    const int64_t mean = (int64_t)dc * scan->weight;
    const int scaled = length ? length + 3 * (CVOL_SUB_BLOCK_SIZES - 1 - size_class) : 0;
    for (int z = 0; z < side; z++)
        for (int y = 0; y < side; y++)
            for (int x = 0; x < side; x++) {
                const int unit = unit_of((const int[3]){at[0] + x, at[1] + y, at[2] + z});
                brick->mean[unit] = mean;
                brick->length[unit] = (uint8_t)scaled;
            }
}

int cvol_brick_context_start(cvol_brick_context *brick, const cvol_array *array,
                             const size_t first[3])
{
    const cvol_file_coding *coding = cvol_coding_of(array);
    brick->true_length = coding->true_length;
    if (!coding->true_length)
        return 1;
    brick->limit = (int32_t)(CVOL_VALUE_LIMIT >> (coding->trellis + coding->true_length));
    for (int a = 0; a < 3; a++) {
        const size_t left = array->grid.dims[a] - CVOL_CELL * first[a];
        brick->inside[a] = left < CVOL_BRICK_SIDE ? (int)left : CVOL_BRICK_SIDE;
    }
    return cvol_true_length_scans_make(&brick->scans, array->grid.dims);
}

const int *cvol_brick_cell_inside(int inside[3], const cvol_brick_context *brick,
                                  const size_t place[3])
{
    int ends = 0;
    for (int a = 0; a < 3 && brick->true_length; a++) {
        const int left = brick->inside[a] - CVOL_CELL * (int)place[a];
        inside[a] = left < CVOL_CELL ? left : CVOL_CELL;
        ends |= left < CVOL_CELL;
    }
    return ends ? inside : NULL;
}

const cvol_scan *cvol_brick_scan_of(const cvol_brick_context *brick, const int at[3],
                                    int size_class, int *seen)
{
    int axes = 0;
    *seen = 1;
    for (int a = 0; a < 3 && brick->true_length; a++) {
        const int left = brick->inside[a] - 4 * at[a];
        axes |= (left > 0 && left < 4 << size_class) << a;
        *seen &= left > 0;
    }
    return axes ? brick->scans.scans[size_class][axes] : cvol_sub_block_scan_of(size_class);
}

const cvol_scan *cvol_brick_scan(const cvol_brick_context *brick, const int at[3], int size_class)
{
    int seen;
    const cvol_scan *scan = cvol_brick_scan_of(brick, at, size_class, &seen);
    return seen ? scan : NULL;
}

/* Rounds symmetrically around 0, so that negated terms give the negated DC. */
int32_t cvol_sub_block_note_unseen(cvol_brick_context *brick, const int at[3], int size_class)
{
    static const int strides[3] = {1, CVOL_BRICK_UNITS, CVOL_BRICK_UNITS * CVOL_BRICK_UNITS};
    int seen;
    const cvol_scan *scan = cvol_brick_scan_of(brick, at, size_class, &seen);
    int64_t sum = 0, count = 0;
    for (int a = 0; a < 3; a++)
        if (at[a]) {
            sum += brick->mean[unit_of(at) - strides[a]];
            count++;
        }
    const int64_t all = count * scan->weight;
    const int64_t size = count ? (2 * (sum < 0 ? -sum : sum) + all) / (2 * all) : 0;
    const int32_t most = (int32_t)(size < brick->limit ? size : brick->limit);
    const int32_t dc = sum < 0 ? -most : most;
    cvol_sub_block_note(brick, at, scan, dc, 0);
    return dc;
}

static int cell_of(const int cell[3])
{
    return cell[0] + CVOL_BRICK_CELLS * (cell[1] + CVOL_BRICK_CELLS * cell[2]);
}

int cvol_split_row(const cvol_brick_context *brick, const int cell[3])
{
    static const int strides[3] = {1, CVOL_BRICK_CELLS, CVOL_BRICK_CELLS * CVOL_BRICK_CELLS};
    int count = 0, sum = 0;
    for (int a = 0; a < 3; a++)
        if (cell[a]) {
            sum += brick->split[cell_of(cell) - strides[a]];
            count++;
        }
    return CVOL_ROW_SPLIT + (count ? 1 + (3 * sum + count / 2) / count : 0);
}

void cvol_split_note(cvol_brick_context *brick, const int cell[3], int token)
{
    brick->split[cell_of(cell)] = (uint8_t)token;
}
