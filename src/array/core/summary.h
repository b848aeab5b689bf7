/* The distribution of a volume's samples, as stored in a file.
 *
 * Transfer functions, windows and guesses of the modality depend on this summary alone. It is
 * computed from all original samples and stored with the compressed array, so they are the same for
 * the original and for every compressed form of it.
 *
 * Counts are stored on a logarithmic scale, in fewer bins for fewer samples, so that the summary of
 * a small volume takes few bytes. The histogram of an uncompressed volume has the same rounding. */
#ifndef CVOL_ARRAY_CORE_SUMMARY_H
#define CVOL_ARRAY_CORE_SUMMARY_H

#include <stdint.h>

#include "array/core/mask.h"
#include "base/team.h"
#include "cvol/base.h"

struct cvol_array;

enum {
    CVOL_SUMMARY_BINS_MIN_LOG2 = 4,
    CVOL_SUMMARY_BINS_MAX_LOG2 = 8,
    CVOL_SUMMARY_BINS = 1 << CVOL_SUMMARY_BINS_MAX_LOG2,
    CVOL_SUMMARY_DISTINCT = 256, /* more distinct values are not counted */
    CVOL_SUMMARY_LEVEL_MAX = 253 /* of a count of 2^63 in quarters of octaves, with margin */
};

typedef enum cvol_summary_state {
    CVOL_SUMMARY_NONE = 0,    /* the array has none: it is computed from the terms */
    CVOL_SUMMARY_KNOWN = 1,   /* of the original samples */
    CVOL_SUMMARY_LEFT_OUT = 2 /* as NONE, and a file of the array has none either */
} cvol_summary_state;

typedef struct cvol_summary {
    cvol_summary_state state;
    int integers; /* 1: all counted samples are integers */
    uint32_t
        distinct; /* different values among them; 0: more than CVOL_SUMMARY_DISTINCT, or unknown */
    double min, max;     /* of the counted samples */
    double mark;         /* the value that means "no value" (cvol/render.h), if mark_count > 0 */
    uint64_t mark_count; /* samples with the mark; they are not counted */
    int bins_log2;       /* 2^bins_log2 equal intervals of min .. max */
    uint8_t levels[CVOL_SUMMARY_BINS]; /* the count of each, by cvol_summary_level */
} cvol_summary;

/* The number of bins (log 2) for a volume of `samples` samples. */
int cvol_summary_bins_log2(size_t samples);
/* A count on the logarithmic scale: 0 for 0, else 1 + 4 e + m where 2^e is the largest power of two
 * in it and m = floor(4 count / 2^e) - 4. */
uint8_t cvol_summary_level(uint64_t count);
/* The count in the middle of a level. */
uint64_t cvol_summary_count(uint8_t level);

/* ---- from samples ----------------------------------------------------------------------- */

/* A summary under construction. Samples are added in one pass or two. */
typedef struct cvol_tally cvol_tally;

/* `fills` (or NULL): bit patterns that are not counted, like NaN and infinity. The caller frees
 * *out. Errors: MEMORY. */
int cvol_tally_create(cvol_context *context, cvol_tally **out, const cvol_grid *grid,
                      const cvol_fills *fills);
void cvol_tally_free(cvol_tally *tally);
/* Adds samples of the grid's type, with all threads. Errors: MEMORY. */
int cvol_tally_add(cvol_context *context, cvol_tally *tally, const void *samples, size_t count);
/* Joins what the processes of a team have added, after each pass; NULL: nothing to do. Errors:
 * those of cvol_team_gather. */
int cvol_tally_share(cvol_context *context, cvol_tally *tally, cvol_team *team);
/* Call it after all samples were added: 1 if they must all be added once more. */
int cvol_tally_needs_another_pass(cvol_tally *tally);
/* Returns 1 if a mark was found; after cvol_tally_needs_another_pass. */
int cvol_tally_has_mark(const cvol_tally *tally);
/* Sets the range; after cvol_tally_needs_another_pass. Values beyond it count at its ends. */
void cvol_tally_set_range(cvol_tally *tally, double min, double max);
void cvol_tally_finish(const cvol_tally *tally, cvol_summary *out);

/* Summarises samples in memory. Errors: MEMORY. */
int cvol_summarise_samples(cvol_context *context, cvol_summary *out, const void *samples,
                           const cvol_grid *grid, const cvol_fills *fills);

/* ---- from terms ------------------------------------------------------------------------- */

/* The array's own summary, or, if it has none, one from a regular subset of its blocks (at most
 * 1,024), evaluated. Volumes only. Errors: MEMORY. */
int cvol_summarise_array(cvol_context *context, cvol_summary *out, const struct cvol_array *array);

/* The array's own summary, of state NONE if it has none. The array owns it. */
const cvol_summary *cvol_array_summary(const struct cvol_array *array);
/* The array keeps a copy of the summary. Errors: MEMORY. */
int cvol_array_set_summary(cvol_context *context, struct cvol_array *array,
                           const cvol_summary *summary);

/* The summary of alpha s + beta for each sample s; none if alpha is 0. */
cvol_summary cvol_summary_scale(const cvol_summary *of, double alpha, double beta);

#endif
