#include "test.h"

#include "support_samples.h"

#include "random.h"

void support_store(void *samples, cvol_type type, size_t i, double v)
{
    switch (type) {
    case CVOL_UINT8:
        ((uint8_t *)samples)[i] = (uint8_t)(127 + 100 * v);
        break;
    case CVOL_INT8:
        ((int8_t *)samples)[i] = (int8_t)(100 * v);
        break;
    case CVOL_UINT16:
        ((uint16_t *)samples)[i] = (uint16_t)(3000 + 2000 * v);
        break;
    case CVOL_INT16:
        ((int16_t *)samples)[i] = (int16_t)(2000 * v);
        break;
    case CVOL_UINT32:
        ((uint32_t *)samples)[i] = (uint32_t)(4e9 + 2e4 * v);
        break;
    case CVOL_INT32:
        ((int32_t *)samples)[i] = (int32_t)(-1e9 + 2e4 * v);
        break;
    case CVOL_FLOAT32:
        ((float *)samples)[i] = (float)(1e-3 * v);
        break;
    case CVOL_FLOAT64:
        ((double *)samples)[i] = 1e6 + v;
        break;
    }
}

double support_load(const void *samples, cvol_type type, size_t i)
{
    switch (type) {
    case CVOL_UINT8:
        return ((const uint8_t *)samples)[i];
    case CVOL_INT8:
        return ((const int8_t *)samples)[i];
    case CVOL_UINT16:
        return ((const uint16_t *)samples)[i];
    case CVOL_INT16:
        return ((const int16_t *)samples)[i];
    case CVOL_UINT32:
        return ((const uint32_t *)samples)[i];
    case CVOL_INT32:
        return ((const int32_t *)samples)[i];
    case CVOL_FLOAT32:
        return (double)((const float *)samples)[i];
    case CVOL_FLOAT64:
        return ((const double *)samples)[i];
    }
    return 0;
}

float *support_waves(const size_t dims[3])
{
    const size_t count = dims[0] * dims[1] * dims[2];
    random_state r = {7};
    float *samples = malloc(count * sizeof *samples);
    assert_non_null(samples);
    for (size_t i = 0; i < count; i++) {
        const double x = (double)(i % dims[0]), y = (double)(i / dims[0] % dims[1]),
                     z = (double)(i / dims[0] / dims[1]);
        samples[i] = (float)(sin(x / 5) * cos(y / 9 + z / 7) + (x + y > z + 20 ? 1.2 : 0) +
                             0.05 * random_signed(&r));
    }
    return samples;
}
