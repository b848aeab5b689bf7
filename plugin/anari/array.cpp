#include "array.h"

#include "types.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <type_traits>

namespace cvol_anari
{

array::array(host &owner, ANARIDataType type, ANARIDataType element, const uint64_t items[3],
             const shared_memory &memory)
    : object(owner, type, ""), element(element), items{items[0], items[1], items[2]}, shared(memory)
{
    if (!shared.data)
        own.resize(count() * size_of(element));
    else
        hold_objects();
}

array::~array()
{
    free_shared();
}

void array::free_shared()
{
    if (shared.data && shared.deleter)
        shared.deleter(shared.user, shared.data);
    shared = shared_memory();
}

/* Shared memory may vanish with the application's reference, unless it waits for its deleter. */
void array::leave_application()
{
    if (!shared.data)
        return;
    const auto *bytes = static_cast<const unsigned char *>(shared.data);
    try {
        own.assign(bytes, bytes + count() * size_of(element));
        free_shared();
    } catch (const std::bad_alloc &) {
        if (shared.deleter)
            return;
        shared = shared_memory();
        std::fill(items, items + 3, 0);
        report(ANARI_SEVERITY_ERROR, ANARI_STATUS_OUT_OF_MEMORY,
               "there is no memory for a copy of what the application shared; it is empty now");
    }
}

void array::hold_objects()
{
    if (!is_object(element))
        return;
    std::vector<reference<object>> now;
    for (object *o : objects())
        now.emplace_back(o);
    held.swap(now);
}

void *array::map()
{
    return const_cast<void *>(data());
}

void array::unmap()
{
    hold_objects();
}

std::vector<object *> array::objects() const
{
    std::vector<object *> out;
    if (is_object(element)) {
        const auto *handles = static_cast<object *const *>(data());
        for (uint64_t i = 0; i < count(); i++)
            if (handles[i])
                out.push_back(handles[i]);
    }
    return out;
}

/* sRGB to linear (IEC 61966-2-1). */
static double decode_srgb(double v)
{
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

/* How an element stores a colour. */
struct colour_format {
    ANARIDataType element;
    double (*read)(const void *data, uint64_t at); /* component `at` of the array */
    uint64_t components;
    bool has_alpha;
};

template <typename T> double read_component(const void *data, uint64_t at)
{
    const double most = std::is_integral<T>::value ? std::numeric_limits<T>::max() : 1;
    return static_cast<double>(static_cast<const T *>(data)[at]) / most;
}

static double read_srgb(const void *data, uint64_t at)
{
    return decode_srgb(read_component<uint8_t>(data, at));
}

#define VECTOR_FORMATS(type, T)                             \
    {ANARI_##type, read_component<T>, 1, false},            \
        {ANARI_##type##_VEC2, read_component<T>, 2, false}, \
        {ANARI_##type##_VEC3, read_component<T>, 3, false}, \
    {                                                       \
        ANARI_##type##_VEC4, read_component<T>, 4, true     \
    }

static const colour_format formats[] = {
    VECTOR_FORMATS(FLOAT32, float),
    VECTOR_FORMATS(FLOAT64, double),
    VECTOR_FORMATS(UFIXED8, uint8_t),
    VECTOR_FORMATS(UFIXED16, uint16_t),
    VECTOR_FORMATS(UFIXED32, uint32_t),
    {ANARI_UFIXED8_R_SRGB, read_srgb, 1, false},
    {ANARI_UFIXED8_RA_SRGB, read_srgb, 2, true},
    {ANARI_UFIXED8_RGB_SRGB, read_srgb, 3, false},
    {ANARI_UFIXED8_RGBA_SRGB, read_srgb, 4, true},
};

/* Missing components are 0, and a missing alpha is 1. */
int array::get_colour(double rgba[4], uint64_t i) const
{
    for (const colour_format &f : formats) {
        if (f.element != element)
            continue;
        const uint64_t colours = f.components - (f.has_alpha ? 1 : 0), first = i * f.components;
        for (uint64_t c = 0; c < 3; c++)
            rgba[c] = c < colours ? f.read(data(), first + c) : 0;
        rgba[3] = 1;
        if (f.has_alpha)
            rgba[3] = element == ANARI_UFIXED8_RA_SRGB || element == ANARI_UFIXED8_RGBA_SRGB
                          ? read_component<uint8_t>(data(), first + colours)
                          : f.read(data(), first + colours);
        return 1;
    }
    return 0;
}

} // namespace cvol_anari
