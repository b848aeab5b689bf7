/* Units of length (unit.h). */
#include "volume/io/unit.h"

#include <stddef.h>
#include <string.h>

double cvol_unit_metres(const char *unit)
{
    static const struct {
        const char *name;
        double metres;
    } units[] = {{"A", 1e-10}, {"\xc3\x85", 1e-10}, {"nm", 1e-9},
                 {"um", 1e-6}, {"\xc2\xb5m", 1e-6}, {"\xce\xbcm", 1e-6},
                 {"mm", 1e-3}, {"cm", 1e-2},        {"m", 1}};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (!strcmp(unit, units[i].name))
            return units[i].metres;
    return 0;
}
