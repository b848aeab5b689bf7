/* The axes of a NRRD: sizes, spacings or space directions, the space and its units. */
#define _GNU_SOURCE
#include "volume/formats/nrrd.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "base/context.h"
#include "volume/io/geometry.h"
#include "volume/io/unit.h"

#define MAX_AXES CVOL_NRRD_AXES

/* ---- words -------------------------------------------------------------------------- */

void cvol_nrrd_get_word(char *out, size_t size, const char *text, size_t index)
{
    *out = '\0';
    for (size_t i = 0; text && *text; i++) {
        text += strspn(text, " \t");
        const size_t length = *text == '"' ? strcspn(text + 1, "\"") : strcspn(text, " \t");
        const char *word = text + (*text == '"');
        if (i == index && length < size) {
            memcpy(out, word, length);
            out[length] = '\0';
            return;
        }
        text = word + length;
        text += *text == '"';
    }
}

/* ---- axes ---------------------------------------------------------------------------- */

/* Parses one "(a,b,c)" or "none" at *text. 1 and its components, 0 for none, -1 if it is
 * neither. */
static int next_vector(const char **text, double vector[3], size_t *components)
{
    *components = 0;
    *text += strspn(*text, " \t");
    if (!strncasecmp(*text, "none", 4)) {
        *text += 4;
        return 0;
    }
    if (**text != '(')
        return -1;
    const char *end = strchr(*text, ')');
    for (const char *at = *text + 1; end && at <= end; ++*components) {
        at += strspn(at, " \t");
        size_t span = strcspn(at, ",)"), length = span;
        while (length && (at[length - 1] == ' ' || at[length - 1] == '\t'))
            length--;
        if (*components == 3 || !cvol_text_number(at, length, &vector[*components]))
            return -1;
        at += span + 1;
    }
    if (!end)
        return -1;
    *text = end + 1;
    return 1;
}

/* The axis of size 1 of four that the grid omits, if the header states no axis of volumes: the last
 * without a direction, else the last; -1 if there is none. */
static int axis_to_leave(const nrrd *n, const int *known)
{
    const size_t *sizes = n->sizes;
    int leave = -1;
    for (int a = 0; a < MAX_AXES && cvol_nrrd_find_stated_extra(n, known) < 0; a++)
        if (sizes[a] == 1 && (leave < 0 || !known[a] || known[leave]))
            leave = a;
    return leave;
}

/* 1 if the header marks an axis as components of a colour: "RGB-color", "4-color". */
static int has_colours(const nrrd *n)
{
    static const char ending[] = "-color";
    const size_t most = sizeof ending - 1;
    const char *kind = n->header.value[NRRD_KINDS];
    while (kind && *kind) {
        kind += strspn(kind, " \t");
        const size_t length = strcspn(kind, " \t");
        if (length > most && !strncasecmp(kind + length - most, ending, most))
            return 1;
        kind += length;
    }
    return 0;
}

static int read_sizes(nrrd *n, const int *known)
{
    size_t *sizes = n->sizes;
    int code = cvol_text_header_sizes(&n->header, NRRD_SIZES, sizes, n->dimension, "dimension");
    if (code)
        return code;
    n->extra_size = 1;
    if (has_colours(n) && n->dimension < MAX_AXES)
        return cvol_text_header_unsupported(
            &n->header, NRRD_KINDS,
            "have an axis of colours, which is not supported: write each "
            "colour into a file of its own");
    int leave = n->dimension == 4 ? axis_to_leave(n, known) : MAX_AXES;
    if (leave < 0) {
        cvol_nrrd_find_extra(n, known);
        leave = (int)n->extra;
    }
    for (size_t a = 0, kept = 0; a < n->dimension; a++)
        if ((int)a != leave) {
            n->grid.dims[kept] = sizes[a];
            n->kept[kept++] = a;
        }
    return CVOL_OK;
}

static int read_dimension(nrrd *n)
{
    int64_t dimension = 0;
    int code = cvol_text_header_integer(&n->header, NRRD_DIMENSION, 1, 16, &dimension);
    if (!code && (dimension < 2 || dimension > MAX_AXES))
        code = cvol_text_header_unsupported(&n->header, NRRD_DIMENSION,
                                            "is not supported: volumes have three axes");
    n->dimension = (size_t)dimension;
    return code;
}

/* One number for each of the file's axes; NaN, the format's word for unknown, without the field. */
static int read_numbers(nrrd *n, int field, double numbers[MAX_AXES])
{
    for (int a = 0; a < MAX_AXES; a++)
        numbers[a] = NAN;
    return cvol_text_header_numbers(&n->header, field, numbers, n->dimension, "dimension");
}

/* Sets axis `a` of the grid by the positions of its ends; *step, signed, is the distance of samples
 * that the header gives, or NaN. The ends are those of the first and the last sample with centers
 * "node". With "cell", which the library of the format takes if they are unknown, each sample is
 * the middle of a cell, and the ends are those of the cells. */
static int set_extent(nrrd *n, int a, double min, double max, double *step)
{
    char center[8];
    cvol_nrrd_get_word(center, sizeof center, n->header.value[NRRD_CENTERS], n->kept[a]);
    const int is_node = !strcasecmp(center, "node");
    const size_t steps = n->grid.dims[a] - (size_t)is_node;
    if (isnan(*step) && isfinite(max - min) && steps > 0) {
        double vector[3] = {0, 0, 0};
        vector[a] = *step = (max - min) / (double)steps;
        if (!cvol_geometry_set_axis(&n->grid, a, vector))
            return cvol_text_header_fail(&n->header, NRRD_AXIS_MAXS, "are those of axis mins");
    }
    if (isfinite(min))
        n->grid.origin[a] = min + (is_node || isnan(*step) ? 0 : *step / 2);
    return CVOL_OK;
}

/* Spacings, and the ends of axes. Directions in space exclude both. */
static int read_spacings(nrrd *n)
{
    double spacings[MAX_AXES], mins[MAX_AXES], maxs[MAX_AXES];
    int code = read_numbers(n, NRRD_SPACINGS, spacings);
    if (!code)
        code = read_numbers(n, NRRD_AXIS_MINS, mins);
    if (!code)
        code = read_numbers(n, NRRD_AXIS_MAXS, maxs);
    for (int a = 0; !code && a < 3 && (size_t)a < n->dimension; a++) {
        const size_t axis = n->kept[a];
        if (!isnan(spacings[axis]))
            n->grid.spacing[a] = spacings[axis];
        if (!n->header.value[NRRD_SPACE_DIRECTIONS])
            code = set_extent(n, a, mins[axis], maxs[axis], &spacings[axis]);
    }
    return code;
}

/* ---- space --------------------------------------------------------------------------- */

/* left-anterior-superior is LPS with the opposite second axis. */
#define SPACE_LAS (-1)

static const cvol_keyword space_words[] = {
    {"left-posterior-superior", CVOL_SPACE_LPS}, {"LPS", CVOL_SPACE_LPS},
    {"right-anterior-superior", CVOL_SPACE_RAS}, {"RAS", CVOL_SPACE_RAS},
    {"left-anterior-superior", SPACE_LAS},       {"LAS", SPACE_LAS},
    {"scanner-xyz", CVOL_SPACE_UNKNOWN},         {"3D-right-handed", CVOL_SPACE_UNKNOWN},
    {"3D-left-handed", CVOL_SPACE_UNKNOWN},
};

/* Components of each vector; 0 if the header does not define them. */
static int read_space_dimension(nrrd *n, size_t *components, int *space)
{
    *components = 0;
    *space = CVOL_SPACE_UNKNOWN;
    if (n->header.value[NRRD_SPACE]) {
        if (!cvol_keyword_find(space_words, CVOL_COUNT(space_words), n->header.value[NRRD_SPACE],
                               space))
            return cvol_text_header_unsupported(&n->header, NRRD_SPACE, "is not supported");
        *components = 3;
    }
    if (!n->header.value[NRRD_SPACE_DIMENSION])
        return CVOL_OK;
    int64_t dimension = 0;
    int code = cvol_text_header_integer(&n->header, NRRD_SPACE_DIMENSION, 1, 3, &dimension);
    *components = (size_t)dimension;
    return code;
}

typedef struct directions {
    int known[MAX_AXES];
    double vector[MAX_AXES][3];
} directions;

static int read_directions(nrrd *n, directions *d, size_t *components)
{
    const char *text = n->header.value[NRRD_SPACE_DIRECTIONS];
    for (size_t a = 0; text && a < n->dimension; a++) {
        size_t count;
        int found = next_vector(&text, d->vector[a], &count);
        if (found > 0 && *components == 0)
            *components = count;
        if (found < 0 || (found && count != *components))
            return cvol_fail(n->header.context, CVOL_ERROR_FORMAT,
                             "%s: space directions '%.80s' are not %zu vectors of %zu numbers",
                             n->header.path, n->header.value[NRRD_SPACE_DIRECTIONS], n->dimension,
                             *components ? *components : 3);
        d->known[a] = found;
    }
    if (text && text[strspn(text, " \t")])
        return cvol_text_header_fail(&n->header, NRRD_SPACE_DIRECTIONS,
                                     "have more vectors than dimension");
    return CVOL_OK;
}

static int set_directions(nrrd *n, const directions *d)
{
    int known[3] = {0, 0, 0};
    for (int a = 0; a < 3 && (size_t)a < n->dimension; a++) {
        size_t axis = n->kept[a];
        if (!d->known[axis] && n->grid.dims[a] > 1)
            return cvol_text_header_unsupported(&n->header, NRRD_SPACE_DIRECTIONS,
                                                "have an axis outside of space");
        if (d->known[axis] && !cvol_geometry_set_axis(&n->grid, a, d->vector[axis]))
            return cvol_text_header_fail(&n->header, NRRD_SPACE_DIRECTIONS,
                                         "have a vector without a length");
        known[a] = d->known[axis];
    }
    cvol_geometry_complete(&n->grid, known);
    return cvol_geometry_check(n->header.context, &n->grid, n->header.path);
}

static int read_origin(nrrd *n, size_t components)
{
    const char *text = n->header.value[NRRD_SPACE_ORIGIN];
    if (!text || cvol_text_equal(text, "none"))
        return CVOL_OK;
    size_t count;
    double origin[3] = {0, 0, 0};
    if (next_vector(&text, origin, &count) < 1 || (components && count != components) || *text)
        return cvol_text_header_fail(&n->header, NRRD_SPACE_ORIGIN, "is not a vector of the space");
    for (int i = 0; i < 3; i++)
        n->grid.origin[i] = isnan(origin[i]) ? 0 : origin[i];
    return CVOL_OK;
}

/* ---- units --------------------------------------------------------------------------- */

/* Reads the units of the space's axes, or, without a space, of the array's. Lengths along such an
 * axis times factor[a] are in the grid's unit. */
static int read_units(nrrd *n, double factor[3])
{
    const int field = n->header.value[NRRD_SPACE_UNITS] ? NRRD_SPACE_UNITS : NRRD_UNITS;
    char word[3][32] = {"", "", ""};
    for (size_t a = 0; a < 3 && (field == NRRD_SPACE_UNITS || a < n->dimension); a++) {
        cvol_nrrd_get_word(word[a], sizeof word[a], n->header.value[field],
                           field == NRRD_SPACE_UNITS ? a : n->kept[a]);
        const int is_flat = field == NRRD_UNITS && n->grid.dims[a] == 1;
        if (!strcmp(word[a], "???") || (is_flat && !(cvol_unit_metres(word[a]) > 0)))
            word[a][0] = '\0';
    }
    const char *const unit[3] = {word[0], word[1], word[2]};
    if (cvol_unit_factors(factor, n->grid.unit, unit))
        return CVOL_OK;
    return cvol_text_header_unsupported(&n->header, field,
                                        "do not convert into each other: write one unit of length, "
                                        "or \"???\" for an unknown one");
}

static void convert_axes(nrrd *n, directions *d, const double factor[3])
{
    for (size_t a = 0; a < 3 && a < n->dimension; a++) {
        n->grid.spacing[a] *= factor[a];
        if (!n->header.value[NRRD_SPACE_ORIGIN])
            n->grid.origin[a] *= factor[a];
        for (int i = 0; i < 3; i++)
            d->vector[n->kept[a]][i] *= factor[a];
    }
}

static void convert_space(nrrd *n, directions *d, const double factor[3])
{
    for (int i = 0; i < 3; i++) {
        for (size_t a = 0; a < n->dimension; a++)
            d->vector[a][i] *= factor[i];
        n->grid.origin[i] *= factor[i];
        if (!n->header.value[NRRD_SPACE_DIRECTIONS])
            n->grid.spacing[i] *= factor[i];
    }
}

int cvol_nrrd_read_axes(nrrd *n)
{
    directions d = {.known = {0}};
    double factor[3] = {1, 1, 1};
    size_t components = 0;
    int space = CVOL_SPACE_UNKNOWN;
    int code = read_dimension(n);
    if (!code)
        code = read_space_dimension(n, &components, &space);
    if (!code)
        code = read_directions(n, &d, &components);
    if (!code)
        code = read_sizes(n, d.known);
    if (!code)
        code = read_spacings(n);
    if (!code)
        code = read_origin(n, components);
    if (!code)
        code = read_units(n, factor);
    if (code) /* the number of axes may be wrong, too */
        return code;
    if (n->header.value[NRRD_SPACE_UNITS])
        convert_space(n, &d, factor);
    else
        convert_axes(n, &d, factor);
    if (n->header.value[NRRD_SPACE_DIRECTIONS])
        code = set_directions(n, &d);
    if (space == SPACE_LAS)
        cvol_geometry_mirror(&n->grid, 1);
    n->grid.space = space == SPACE_LAS ? CVOL_SPACE_LPS : (cvol_space)space;
    return code;
}
