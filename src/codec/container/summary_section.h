/* Section SUMM: the distribution of a volume's original samples (array/core/summary.h). */
#ifndef CVOL_CODEC_CONTAINER_SUMMARY_SECTION_H
#define CVOL_CODEC_CONTAINER_SUMMARY_SECTION_H

#include "array/core/summary.h"
#include "codec/container/header.h"
#include "codec/section/section.h"

/* Appends the section's content, from the header's summary and range of values. Check
 * out->failed. */
void cvol_summary_put(cvol_bytes *out, const cvol_header *header);
/* Reads it into the header. Errors: CORRUPT. */
int cvol_summary_take(cvol_context *context, cvol_header *header, cvol_cursor *content,
                      const char *name);
/* The bytes that the section adds to a file; UINT64_MAX without memory. */
uint64_t cvol_summary_section_bytes(const cvol_summary *summary,
                                    const cvol_error_bound *error_bound);

#endif
