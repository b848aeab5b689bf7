/* The distance of a series' times, for formats that store only that. */
#ifndef CVOL_VOLUME_IO_TIME_STEP_H
#define CVOL_VOLUME_IO_TIME_STEP_H

#include "cvol/series.h"

/* The distance of times; 0: they are not evenly spaced, decrease, or have no values. */
double cvol_series_time_step(const cvol_series_options *series);

#endif
