/* The distance of a series' times (time_step.h). */
#include "volume/io/time_step.h"

#include <math.h>

double cvol_series_time_step(const cvol_series_options *series)
{
    const double *t = series->time_values;
    const int last = series->times - 1;
    if (!t || last < 1)
        return 0;
    const double step = (t[last] - t[0]) / last;
    for (int i = 0; i <= last; i++)
        if (!(fabs(t[i] - t[0] - i * step) <= 1e-6 * fabs(step)))
            return 0;
    return step > 0 ? step : 0;
}
