#include "types.h"

namespace cvol_anari
{

bool is_object(ANARIDataType type)
{
    return type >= ANARI_OBJECT && type <= ANARI_WORLD;
}

#define VECTORS(type, bytes)  \
    case ANARI_##type:        \
        return bytes;         \
    case ANARI_##type##_VEC2: \
        return 2 * (bytes);   \
    case ANARI_##type##_VEC3: \
        return 3 * (bytes);   \
    case ANARI_##type##_VEC4: \
        return 4 * (bytes)

size_t size_of(ANARIDataType type)
{
    if (is_object(type))
        return sizeof(void *);
    switch (static_cast<int>(type)) {
        VECTORS(INT8, 1);
        VECTORS(UINT8, 1);
        VECTORS(FIXED8, 1);
        VECTORS(UFIXED8, 1);
        VECTORS(INT16, 2);
        VECTORS(UINT16, 2);
        VECTORS(FIXED16, 2);
        VECTORS(UFIXED16, 2);
        VECTORS(FLOAT16, 2);
        VECTORS(INT32, 4);
        VECTORS(UINT32, 4);
        VECTORS(FIXED32, 4);
        VECTORS(UFIXED32, 4);
        VECTORS(FLOAT32, 4);
        VECTORS(INT64, 8);
        VECTORS(UINT64, 8);
        VECTORS(FIXED64, 8);
        VECTORS(UFIXED64, 8);
        VECTORS(FLOAT64, 8);
    case ANARI_UFIXED8_R_SRGB:
        return 1;
    case ANARI_UFIXED8_RA_SRGB:
        return 2;
    case ANARI_UFIXED8_RGB_SRGB:
        return 3;
    case ANARI_UFIXED8_RGBA_SRGB:
        return 4;
    case ANARI_BOOL:
    case ANARI_DATA_TYPE:
        return 4;
    case ANARI_VOID_POINTER:
    case ANARI_STATUS_CALLBACK:
    case ANARI_MEMORY_DELETER:
    case ANARI_FRAME_COMPLETION_CALLBACK:
    case ANARI_FLOAT32_BOX1:
        return 8;
    case ANARI_FLOAT32_BOX2:
#ifdef ANARI_FLOAT64_BOX1 /* newer SDKs */
    case ANARI_FLOAT64_BOX1:
#endif
    case ANARI_FLOAT32_QUAT_IJKW:
        return 16;
    case ANARI_FLOAT32_BOX3:
        return 24;
    case ANARI_FLOAT32_MAT3:
        return 36;
    case ANARI_FLOAT32_MAT3x4:
        return 48;
    case ANARI_FLOAT32_MAT4:
        return 64;
    default:
        return 0;
    }
}

const char *type_name(ANARIDataType type)
{
    static const struct {
        ANARIDataType type;
        const char *name;
    } names[] = {{ANARI_DEVICE, "device"},
                 {ANARI_ARRAY1D, "array"},
                 {ANARI_ARRAY2D, "array"},
                 {ANARI_ARRAY3D, "array"},
                 {ANARI_CAMERA, "camera"},
                 {ANARI_FRAME, "frame"},
                 {ANARI_GEOMETRY, "geometry"},
                 {ANARI_GROUP, "group"},
                 {ANARI_INSTANCE, "instance"},
                 {ANARI_LIGHT, "light"},
                 {ANARI_MATERIAL, "material"},
                 {ANARI_RENDERER, "renderer"},
                 {ANARI_SURFACE, "surface"},
                 {ANARI_SAMPLER, "sampler"},
                 {ANARI_SPATIAL_FIELD, "spatial field"},
                 {ANARI_VOLUME, "volume"},
                 {ANARI_WORLD, "world"}};
    for (const auto &n : names)
        if (n.type == type)
            return n.name;
    return "object";
}

} // namespace cvol_anari
