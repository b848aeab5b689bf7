/* Terms of shares (share.h). */
#include "array/core/share.h"

int cvol_share_count_terms(cvol_context *context, uint64_t *count, const cvol_array *array)
{
    const cvol_share share = cvol_share_of(context, array);
    const int place_bits = cvol_place_bits(array->block_log2);
    *count = 0;
    for (size_t i = share.blocks[0]; i < share.blocks[1]; i++) {
        const cvol_block *block = &array->block_table[i];
        const uint32_t *words = block->terms, *end = cvol_block_end(block);
        uint32_t place;
        for (; words < end; ++*count)
            (void)cvol_term_unpack(&words, &place, place_bits);
    }
    return cvol_team_add(context, share.team, CVOL_OK, count);
}
