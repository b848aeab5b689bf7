/* The labels of a volume, and a choice of them: --labels 3,5,7-9 or names. */
#include <ctype.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "tools/labels/labels.h"

/* Labels that differ by more are counted in a hash table. */
#define RANGE_MOST (1 << 24)

/* ---- counting ---- */

double value_at(const cvol_volume *volume, size_t i)
{
    switch (volume->grid.type) {
    case CVOL_UINT8:
        return ((const uint8_t *)volume->data)[i];
    case CVOL_INT8:
        return ((const int8_t *)volume->data)[i];
    case CVOL_UINT16:
        return ((const uint16_t *)volume->data)[i];
    case CVOL_INT16:
        return ((const int16_t *)volume->data)[i];
    case CVOL_UINT32:
        return ((const uint32_t *)volume->data)[i];
    case CVOL_INT32:
        return ((const int32_t *)volume->data)[i];
    case CVOL_FLOAT32:
        return (double)((const float *)volume->data)[i];
    default:
        return ((const double *)volume->data)[i];
    }
}

int label_at(const cvol_volume *volume, size_t i)
{
    return (int)value_at(volume, i);
}

/* 1 if all samples are whole numbers of type int; sets their range. */
static int find_range(int range[2], const cvol_volume *volume)
{
    const size_t count = cvol_grid_samples(&volume->grid);
    range[0] = INT_MAX;
    range[1] = INT_MIN;
    for (size_t i = 0; i < count; i++) {
        const double value = value_at(volume, i);
        if (!(value >= INT_MIN && value <= INT_MAX) || (double)(int)value < value ||
            (double)(int)value > value)
            return 0;
        range[0] = (int)value < range[0] ? (int)value : range[0];
        range[1] = (int)value > range[1] ? (int)value : range[1];
    }
    return 1;
}

static int list_values(label_values *out, const uint64_t *counts, size_t range, int least)
{
    size_t count = 0, commonest = 0;
    for (size_t i = 0; i < range; i++)
        count += counts[i] > 0;
    out->values = calloc(count, sizeof *out->values);
    out->samples = calloc(count, sizeof *out->samples);
    if (!out->values || !out->samples)
        return report_error(EXIT_FAILED, "not enough memory");
    for (size_t i = 0; i < range; i++) {
        if (!counts[i])
            continue;
        out->values[out->count] = least + (int)i;
        out->samples[out->count++] = counts[i];
        commonest = counts[i] > counts[commonest] ? i : commonest;
    }
    const int has_zero = least <= 0 && -(double)least < (double)range && counts[-(long)least];
    out->background = has_zero ? 0 : least + (int)commonest;
    return EXIT_DONE;
}

/* ---- counting labels that are far apart ---- */

typedef struct place {
    int value;
    uint64_t samples; /* 0: free */
} place;

/* A hash table with open addressing, at most half full. */
typedef struct counter {
    place *places;
    size_t room, count; /* room: a power of two */
} counter;

static place *find_place(const counter *c, int value)
{
    size_t at = (size_t)((uint64_t)(uint32_t)value * 0x9e3779b97f4a7c15 >> 24);
    for (at &= c->room - 1; c->places[at].samples && c->places[at].value != value;)
        at = (at + 1) & (c->room - 1);
    return &c->places[at];
}

static int grow(counter *c)
{
    const counter old = *c;
    c->room = old.room ? 2 * old.room : 1 << 10;
    c->places = calloc(c->room, sizeof *c->places);
    for (size_t i = 0; c->places && i < old.room; i++)
        if (old.places[i].samples)
            *find_place(c, old.places[i].value) = old.places[i];
    free(old.places);
    return c->places != NULL;
}

static int compare_places(const void *a, const void *b)
{
    const int x = ((const place *)a)->value, y = ((const place *)b)->value;
    return (x > y) - (x < y);
}

/* 0: no memory. */
static int count_places(counter *c, const cvol_volume *volume)
{
    const size_t samples = cvol_grid_samples(&volume->grid);
    for (size_t i = 0; i < samples; i++) {
        const int value = label_at(volume, i);
        if (2 * c->count >= c->room && !grow(c))
            return 0;
        place *at = find_place(c, value);
        c->count += !at->samples;
        at->value = value;
        at->samples++;
    }
    for (size_t i = 0, used = 0; i < c->room; i++)
        if (c->places[i].samples)
            c->places[used++] = c->places[i];
    qsort(c->places, c->count, sizeof *c->places, compare_places);
    return 1;
}

static int count_far_labels(label_values *out, const cvol_volume *volume)
{
    counter c = {0};
    const int is_counted = count_places(&c, volume);
    out->values = calloc(c.count, sizeof *out->values);
    out->samples = calloc(c.count, sizeof *out->samples);
    if (!is_counted || !out->values || !out->samples) {
        free(c.places);
        free_values(out);
        return report_error(EXIT_FAILED, "not enough memory");
    }
    size_t commonest = 0;
    int has_zero = 0;
    for (size_t i = 0; i < c.count; i++) {
        out->values[i] = c.places[i].value;
        out->samples[i] = c.places[i].samples;
        commonest = out->samples[i] > out->samples[commonest] ? i : commonest;
        has_zero = has_zero || !out->values[i];
    }
    out->count = c.count;
    out->background = has_zero ? 0 : out->values[commonest];
    free(c.places);
    return EXIT_DONE;
}

int count_labels(label_values *out, const cvol_volume *volume, const char *path)
{
    const size_t samples = cvol_grid_samples(&volume->grid);
    int range[2];
    *out = (label_values){0};
    const int are_labels = find_range(range, volume);
    if (!are_labels && !cvol_type_is_integer(volume->grid.type))
        return report_error(EXIT_MISUSED, "%s: its samples are not whole numbers, so no labels",
                            path);
    if (!are_labels)
        return report_error(EXIT_MISUSED,
                            "%s: its samples are not whole numbers from %d to %d, so no labels",
                            path, INT_MIN, INT_MAX);
    const int64_t width = (int64_t)range[1] - range[0] + 1;
    if (width > RANGE_MOST)
        return count_far_labels(out, volume);
    uint64_t *counts = calloc((size_t)width, sizeof *counts);
    if (!counts)
        return report_error(EXIT_FAILED, "not enough memory");
    for (size_t i = 0; i < samples; i++)
        counts[label_at(volume, i) - range[0]]++;
    const int status = list_values(out, counts, (size_t)width, range[0]);
    free(counts);
    return status;
}

int has_label_range(const cvol_volume *volume)
{
    int range[2];
    return find_range(range, volume);
}

void free_values(label_values *values)
{
    free(values->values);
    free(values->samples);
    *values = (label_values){0};
}

/* ---- choosing ---- */

/* Reads "7" or "7-9". */
static int parse_range(int range[2], const char *text, size_t length)
{
    char word[64], *end;
    if (length >= sizeof word)
        return 0;
    memcpy(word, text, length);
    word[length] = '\0';
    for (int k = 0; k < 2; k++) {
        const char *at = k ? end + 1 : word;
        const long value = strtol(at, &end, 10);
        if (end == at || isspace((unsigned char)*at) || value < INT_MIN || value > INT_MAX)
            return 0;
        range[k] = (int)value;
        if (!*end && !k)
            range[++k] = (int)value;
        else if (!k && *end != '-')
            return 0;
    }
    return !*end;
}

static int choose_range(uint8_t *chosen, const label_values *values, const int range[2],
                        const char *path)
{
    int found = 0;
    for (size_t i = 0; i < values->count; i++)
        if (values->values[i] >= range[0] && values->values[i] <= range[1])
            found = chosen[i] = 1;
    if (found)
        return EXIT_DONE;
    const int least = values->values[0], most = values->values[values->count - 1];
    if (range[0] != range[1])
        return report_error(EXIT_MISUSED,
                            "%s: no sample has a label of %d to %d; labels are %d to %d", path,
                            range[0], range[1], least, most);
    return report_error(EXIT_MISUSED, "%s: no sample has label %d; labels are %d to %d", path,
                        range[0], least, most);
}

static int choose_name(uint8_t *chosen, const label_values *values, const label_table *table,
                       const char *text, size_t length, const label_choice *choice,
                       const char *path)
{
    int known = 0, found = 0;
    if (!table->count)
        return report_error(EXIT_MISUSED,
                            "%s has '%.*s', but %s has no names: give numbers, as in 3,5,7-9, or "
                            "%s FILE",
                            choice->option, (int)length, text, path, choice->file_option);
    for (size_t k = 0; k < table->count; k++) {
        const label_entry *of = &table->entries[k];
        if (strlen(of->name) != length || strncasecmp(of->name, text, length))
            continue;
        known = 1;
        for (size_t i = 0; i < values->count; i++)
            if (values->values[i] == of->value)
                found = chosen[i] = 1;
    }
    if (found)
        return EXIT_DONE;
    return report_error(EXIT_MISUSED,
                        known ? "%s: no sample has the label '%.*s'"
                              : "%s: no label has the name '%.*s'; cvol info lists them",
                        path, (int)length, text);
}

int choose_label_values(uint8_t *chosen, const label_values *values, const label_table *table,
                        const label_choice *choice, const char *path)
{
    const char *const text = choice->text;
    int status = EXIT_DONE;
    memset(chosen, 0, values->count);
    for (size_t i = 0; i < values->count && !text; i++)
        chosen[i] = values->values[i] != values->background;
    for (const char *at = text; at && !status;) {
        const size_t length = strcspn(at, ",");
        int range[2];
        if (!length)
            return report_error(EXIT_MISUSED,
                                "%s is '%s', must be numbers or names with commas between them, as "
                                "in 3,5,7-9",
                                choice->option, text);
        status = parse_range(range, at, length)
                     ? choose_range(chosen, values, range, path)
                     : choose_name(chosen, values, table, at, length, choice, path);
        at = at[length] ? at + length + 1 : NULL;
    }
    return status;
}
