/* The critical bin: coefficients that are packed before it is decided if they are kept. */
#include <stdlib.h>

#include "array/block/block_transform.h"
#include "array/truncate/build_runs.h"
#include "base/context.h"
#include "base/memory.h"

static cvol_candidate candidate_of(const cvol_builder *b, size_t run_index,
                                   const cvol_critical_candidate *u)
{
    uint32_t group = u->place;
    if (b->array->transform == CVOL_DFT) {
        const uint32_t other = cvol_block_partner(b->array, u->place);
        group = other < group ? other : group;
    }
    return (cvol_candidate){cvol_run_begin(b, run_index) + u->block, group, u->key};
}

/* Removes a run's candidates behind the last kept one (NULL: all) from its blocks. */
static void drop_candidates(const cvol_builder *b, size_t run_index, const cvol_candidate *last)
{
    cvol_build_run *r = &b->runs[run_index];
    const int bits = cvol_place_bits(b->array->block_log2);
    const size_t begin = cvol_run_begin(b, run_index);
    uint32_t *to = r->terms;
    const uint32_t *from = r->terms;
    size_t next = 0;
    for (size_t i = begin; i < cvol_run_begin(b, run_index + 1); i++) {
        cvol_block *block = &b->array->block_table[i];
        const uint32_t *end = from + block->words, *first = to;
        while (from < end) {
            uint32_t place;
            const uint32_t *at = from;
            const int32_t value = cvol_term_unpack(&from, &place, bits);
            const cvol_critical_candidate *u = &r->candidates[next];
            int keep = 1;
            if (next < r->candidate_count && u->block == i - begin && u->place == place) {
                const cvol_candidate c = candidate_of(b, run_index, u);
                const double whole = (double)u->value, rest = whole - b->step * (double)value;
                keep = last && cvol_candidate_order(&c, last) <= 0;
                r->lost += keep ? 0 : whole * whole - rest * rest;
                r->coefficients -= !keep;
                next++;
            }
            for (; keep && at < from; at++)
                *to++ = *at;
        }
        block->words = (uint32_t)(to - first);
        block->terms = first;
        cvol_block_find_low(block, b->array->block_log2);
    }
    r->words = (size_t)(to - r->terms);
    uint32_t *shorter = r->words ? realloc(r->terms, r->words * sizeof *shorter) : NULL;
    if (r->words == 0) {
        free(r->terms);
        r->terms = NULL;
    } else if (shorter) {
        r->terms = shorter;
    }
    cvol_run_place_terms(b, run_index);
}

int cvol_build_commit(cvol_context *context, cvol_builder *b, const cvol_selection *selection)
{
    size_t count = 0;
    for (size_t r = 0; r < b->run_count; r++)
        count += b->runs[r].candidate_count;
    if (!count)
        return CVOL_OK;
    cvol_candidate *all = cvol_allocate(count, sizeof *all);
    if (!all)
        return cvol_fail_memory(context, count * sizeof *all, b->producer->what);
    size_t n = 0;
    for (size_t r = 0; r < b->run_count; r++)
        for (size_t i = 0; i < b->runs[r].candidate_count; i++)
            all[n++] = candidate_of(b, r, &b->runs[r].candidates[i]);
    const size_t kept = cvol_select_candidates(all, count, selection);
    if (kept)
        b->array->threshold = (double)all[kept - 1].key;
#pragma omp parallel for schedule(dynamic) num_threads(cvol_context_threads(context))
    for (size_t r = 0; r < b->run_count; r++)
        if (b->runs[r].candidate_count)
            drop_candidates(b, r, kept ? &all[kept - 1] : NULL);
    free(all);
    return CVOL_OK;
}
