/* Edit distance of words: letters deleted, inserted, replaced or exchanged with a neighbour
 * (optimal string alignment distance). */
#include "tools/base/cli.h"

#include <string.h>

enum { LONGEST = 40 };

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

size_t spelling_distance(const char *a, size_t a_length, const char *b)
{
    const size_t b_length = strlen(b);
    size_t rows[3][LONGEST + 1]; /* the last two rows of the table, and this one */
    if (a_length > LONGEST || b_length > LONGEST)
        return SPELLING_FAR;
    for (size_t j = 0; j <= b_length; j++)
        rows[0][j] = j;
    for (size_t i = 1; i <= a_length; i++) {
        size_t *row = rows[i % 3], *last = rows[(i + 2) % 3], *before = rows[(i + 1) % 3];
        row[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            row[j] = least(least(row[j - 1], last[j]) + 1, last[j - 1] + (a[i - 1] != b[j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = least(row[j], before[j - 2] + 1);
        }
    }
    return rows[a_length % 3][b_length];
}

size_t spelling_near(size_t length)
{
    return least(length / 4, 2);
}
