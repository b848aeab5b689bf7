/* What the formats of cvol decompress cannot store. */
#include <string.h>

#include "tools/compress/decompress.h"

/* 1 if the volume has a scale and offset of values that the output's format cannot store. */
int loses_rescale(const part *p, const char *out_path)
{
    static const char *const keep[] = {".nii", ".nii.gz", ".mha", ".mhd"};
    for (size_t i = 0; i < sizeof keep / sizeof *keep; i++)
        if (has_ending(out_path, keep[i]))
            return 0;
    return p->grid.value_scale != 1 || p->grid.value_offset != 0;
}

/* What the other formats keep of the geometry; the last that the name ends in counts. */
typedef struct kept {
    const char *ending;
    int spacing; /* 2: only in a unit of length */
    int directions, origin, space;
    int unit; /* 1: units of length, 2: any */
} kept;
static const kept formats[] = {
    {".tif", 1, 0, 0, 0, 2},      {".tiff", 1, 0, 0, 0, 2}, {".vti", 1, 1, 1, 0, 0},
    {".zarr", 1, 0, 1, 0, 1},     {".mrc", 1, 0, 1, 0, 1},  {".mgz", 1, 1, 1, 1, 1},
    {".mgh", 1, 1, 1, 1, 1},      {".npy", 0, 0, 0, 0, 0},  {".raw", 0, 0, 0, 0, 0},
    {".h5", 2, 0, 0, 0, 1},       {".hdf5", 2, 0, 0, 0, 1}, {".ome.tif", 1, 0, 0, 0, 1},
    {".ome.tiff", 1, 0, 0, 0, 1}, {".nii", 1, 1, 1, 1, 1},  {".nii.gz", 1, 1, 1, 1, 1},
    {".mha", 1, 1, 1, 1, 1},      {".mhd", 1, 1, 1, 1, 1},
};

static int is_length(const char *unit)
{
    static const char *const known[] = {"pm", "A", "nm", "um", "mm", "cm", "m", "inch"};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (!strcmp(unit, known[i]))
            return 1;
    return 0;
}

/* Finds the properties of the geometry that the output's format cannot store: at most PLACES names.
 * Returns their number. */
enum { PLACES = 5 };
static int lost_places(const part *p, const char *out_path, const char *lost[PLACES])
{
    const cvol_grid *g = &p->grid;
    const kept *format = NULL;
    int spaced = 0, placed = 0, turned = 0, count = 0;
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (has_ending(out_path, formats[i].ending))
            format = &formats[i];
    if (!format)
        return 0;
    for (int a = 0; a < 3; a++) {
        spaced |= g->spacing[a] != 1;
        placed |= g->origin[a] != 0;
        for (int i = 0; i < 3; i++)
            turned |= g->direction[a][i] != (a == i);
    }
    if (spaced && (!format->spacing || (format->spacing == 2 && !is_length(g->unit))))
        lost[count++] = "spacing";
    if (turned && !format->directions)
        lost[count++] = "directions";
    if (placed && !format->origin)
        lost[count++] = "origin";
    if (g->space != CVOL_SPACE_UNKNOWN && !format->space)
        lost[count++] = "patient space";
    if (g->unit[0] && (!format->unit || (format->unit == 1 && !is_length(g->unit))))
        lost[count++] = "unit";
    return count;
}

void print_lost_places(const part *p, const char *out_path)
{
    const char *lost[PLACES];
    const int count = lost_places(p, out_path, lost);
    for (int i = 0; i < count; i++)
        printf("%s%s", !i ? "; the format cannot store " : i + 1 < count ? ", " : " and ", lost[i]);
}

json_t *json_lost_places(const part *p, const char *out_path)
{
    const char *lost[PLACES];
    const int count = lost_places(p, out_path, lost);
    json_t *list = json_array();
    for (int i = 0; i < count; i++)
        json_array_append_new(list, json_string(lost[i]));
    return list;
}
