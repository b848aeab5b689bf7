/* Units of length (unit.h). */
#include "volume/io/unit.h"

#include <stdio.h>
#include <string.h>

/* Names of grids, and the unit in picometres: quotients of these integers are rounded once. */
static const struct {
    const char *name;
    double picometres;
} units[] = {{"pm", 1},   {"A", 100},   {"nm", 1e3}, {"um", 1e6},
             {"mm", 1e9}, {"cm", 1e10}, {"m", 1e12}, {"inch", 2.54e10}};

enum { UNITS = sizeof units / sizeof *units };

/* Other names in files: those of UDUNITS in OME-Zarr, symbols with either letter for micro or in
 * Latin-1, and ImageJ's. */
static const char *const spellings[][2] = {
    {"picometer", "pm"}, {"angstrom", "A"},    {"\xc3\x85", "A"},    {"\xc5", "A"},
    {"nanometer", "nm"}, {"micrometer", "um"}, {"\xc2\xb5m", "um"},  {"\xce\xbcm", "um"},
    {"\xb5m", "um"},     {"\\u00B5m", "um"},   {"\\u00b5m", "um"},   {"micron", "um"},
    {"microns", "um"},   {"millimeter", "mm"}, {"centimeter", "cm"}, {"meter", "m"},
    {"in", "inch"},
};

static int is_name(const char *name, const char *text, size_t size)
{
    return strlen(name) == size && !memcmp(name, text, size);
}

/* The index of a unit of length, or UNITS. */
static size_t find_unit(const char *text, size_t size)
{
    for (size_t s = 0; s < sizeof spellings / sizeof *spellings; s++)
        if (is_name(spellings[s][0], text, size)) {
            text = spellings[s][1];
            size = strlen(text);
            break;
        }
    size_t i = 0;
    while (i < UNITS && !is_name(units[i].name, text, size))
        i++;
    return i;
}

double cvol_unit_metres(const char *unit)
{
    const size_t i = find_unit(unit, strlen(unit));
    return i < UNITS ? units[i].picometres / 1e12 : 0;
}

const char *cvol_unit_of_length(const char *text, size_t size)
{
    const size_t i = find_unit(text, size);
    return i < UNITS ? units[i].name : NULL;
}

int cvol_unit_factors(double factor[3], char common[16], const char *const unit[3])
{
    const char *first = "";
    for (int a = 2; a >= 0; a--)
        first = *unit[a] ? unit[a] : first;
    const size_t to = find_unit(first, strlen(first));
    for (int a = 0; a < 3; a++) {
        const size_t from = find_unit(unit[a], strlen(unit[a]));
        factor[a] = 1;
        if (from < UNITS && to < UNITS)
            factor[a] = units[from].picometres / units[to].picometres;
        else if (*unit[a] && strcmp(unit[a], first) != 0)
            return 0;
    }
    snprintf(common, 16, "%s", to < UNITS ? units[to].name : first);
    return 1;
}
