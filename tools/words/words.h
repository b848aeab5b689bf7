/* The words for values of enumerations, which the command and the viewer share: one table for each
 * enumeration, and one parser and one printer for all of them. */
#ifndef CVOL_TOOLS_WORDS_WORDS_H
#define CVOL_TOOLS_WORDS_WORDS_H

#include <stddef.h>

typedef struct word_value {
    const char *word;
    int value;
} word_value;

/* If several words mean one value, the first is printed. */
typedef struct word_table {
    const word_value *words;
    size_t count;
} word_table;

/* Enumerations of the library. */
extern const word_table mode_words, engine_words, transform_words, type_words, plan_words;
extern const word_table footprint_words, sheet_footprint_words, ray_order_words;
extern const word_table order_words, plane_words, schedule_words, effort_words;
/* Axes 0, 1, 2; and cvol_space. */
extern const word_table axis_words, space_words;

/* Choices of the command. */
enum { LABELS_AUTO, LABELS_YES, LABELS_NO };
enum { PICTURE_BLACK, PICTURE_WHITE, PICTURE_GRADIENT, PICTURE_TRANSPARENT };
enum { LIGHT_STUDIO, LIGHT_CINEMATIC, LIGHT_HEADLIGHT, LIGHT_FLAT, LIGHT_DIRECTION };
enum { FIT_OBJECT, FIT_TURN, FIT_BOX };
extern const word_table labels_words, picture_background_words, light_words, fit_words;
extern const word_table background_words; /* cvol_background, but for a value */
extern const word_table as_words;         /* 1: files are channels, not times */

/* 1 and the word's value if it is in the table. */
int find_word(int *out, const word_table *table, const char *word);
/* The word for a value of the table. */
const char *word_of(const word_table *table, int value);

/* The table's words, with `between` between them and `last` before the last; `text` has room for
 * them. */
enum { WORD_LIST = 160 };
const char *list_words(char text[WORD_LIST], const word_table *table, const char *between,
                       const char *last);

#endif
