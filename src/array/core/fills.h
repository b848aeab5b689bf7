/* Fills: the bit patterns of the samples that a mask describes (mask.h). */
#ifndef CVOL_ARRAY_CORE_FILLS_H
#define CVOL_ARRAY_CORE_FILLS_H

#include <stddef.h>
#include <stdint.h>

#include "cvol/base.h"

enum { CVOL_FILLS_MAX = 7 };

/* Bit patterns of a sample type, in the low bits. */
typedef struct cvol_fills {
    int count;
    int background; /* the samples have a value: the only fill */
    uint64_t bits[CVOL_FILLS_MAX];
} cvol_fills;

/* Adds a pattern, if it is new; 0 if there are too many. */
int cvol_fills_add(cvol_fills *fills, uint64_t bits);
/* Adds other patterns, and sets number[1 + i] to 1 + the place of other->bits[i]: 1 if there are
 * too many. */
void cvol_fills_unite(uint8_t number[CVOL_FILLS_MAX + 1], cvol_fills *fills,
                      const cvol_fills *other);
/* Converts the patterns from one type to another; integers are rounded. 0 if a value without a
 * meaning, such as NaN, has no pattern in that type. */
int cvol_fills_convert(cvol_fills *fills, cvol_type from, cvol_type to);
/* The pattern of a value in a type, for floats the nearest one; 0 if the type has none. */
int cvol_fills_of_value(uint64_t *bits, cvol_type type, double value);
/* The value of a pattern in a type. */
double cvol_fills_value(const cvol_fills *fills, int which, cvol_type type);
/* Adds the patterns of all NaN and infinite samples; 0 if there are too many. */
int cvol_fills_add_nonfinite(cvol_fills *fills, cvol_type type, const void *samples, size_t count);
/* which[i] = 1 + the number of sample i's fill; 0: none. Returns how many are not 0. */
size_t cvol_fills_match(uint8_t *which, const cvol_fills *fills, cvol_type type,
                        const void *samples, size_t count);

#endif
