#include "queries.h"

#include "types.h"

#include <cstring>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

namespace cvol_anari
{

const char **extensions()
{
    static const char *list[] = {
        "ANARI_KHR_CAMERA_ORTHOGRAPHIC",        "ANARI_KHR_CAMERA_PERSPECTIVE",
        "ANARI_KHR_FRAME_COMPLETION_CALLBACK",  "ANARI_KHR_INSTANCE_TRANSFORM",
        "ANARI_KHR_LIGHT_DIRECTIONAL",          "ANARI_KHR_RENDERER_BACKGROUND_COLOR",
        "ANARI_KHR_RENDERER_BACKGROUND_IMAGE",  "ANARI_KHR_SPATIAL_FIELD_STRUCTURED_REGULAR",
        "ANARI_KHR_VOLUME_TRANSFER_FUNCTION1D", nullptr};
    return list;
}

const char **subtypes(ANARIDataType type)
{
    static const char *cameras[] = {"perspective", "orthographic", nullptr};
    static const char *fields[] = {"structuredRegular", "cvol", nullptr};
    static const char *volumes[] = {"transferFunction1D", nullptr};
    static const char *renderers[] = {"default", "lit", nullptr};
    static const char *lights[] = {"directional", nullptr};
    static const char *instances[] = {"transform", nullptr};
    static const char *none[] = {nullptr};
    switch (static_cast<int>(type)) {
    case ANARI_CAMERA:
        return cameras;
    case ANARI_SPATIAL_FIELD:
        return fields;
    case ANARI_VOLUME:
        return volumes;
    case ANARI_RENDERER:
        return renderers;
    case ANARI_LIGHT:
        return lights;
    case ANARI_INSTANCE:
        return instances;
    default:
        return none;
    }
}

/* ---- parameters ------------------------------------------------------------------------------ */

/* One type of a parameter; a parameter of several types has several rows. */
struct parameter_fact {
    ANARIDataType type;
    const char *subtype; /* NULL: every one */
    const char *name;
    ANARIDataType parameter_type;
    bool is_required;
    const char *description;
};

static const parameter_fact facts[] = {
    {ANARI_DEVICE, nullptr, "statusCallback", ANARI_STATUS_CALLBACK, false, "receives messages"},
    {ANARI_DEVICE, nullptr, "statusCallbackUserData", ANARI_VOID_POINTER, false,
     "first argument of statusCallback"},

    {ANARI_CAMERA, nullptr, "position", ANARI_FLOAT32_VEC3, false, "place of the eye"},
    {ANARI_CAMERA, nullptr, "direction", ANARI_FLOAT32_VEC3, false, "where it looks"},
    {ANARI_CAMERA, nullptr, "up", ANARI_FLOAT32_VEC3, false, "what is up in the picture"},
    {ANARI_CAMERA, nullptr, "imageRegion", ANARI_FLOAT32_BOX2, false,
     "the part of the picture that is shown"},
    {ANARI_CAMERA, nullptr, "aspect", ANARI_FLOAT32, false, "width divided by height"},
    {ANARI_CAMERA, "perspective", "fovy", ANARI_FLOAT32, false, "vertical field of view, radians"},
    {ANARI_CAMERA, "orthographic", "height", ANARI_FLOAT32, false, "height of the picture"},

    {ANARI_FRAME, nullptr, "world", ANARI_WORLD, true, "what is drawn"},
    {ANARI_FRAME, nullptr, "camera", ANARI_CAMERA, true, "from where"},
    {ANARI_FRAME, nullptr, "renderer", ANARI_RENDERER, true, "how"},
    {ANARI_FRAME, nullptr, "size", ANARI_UINT32_VEC2, true, "width and height in pixels"},
    {ANARI_FRAME, nullptr, "channel.color", ANARI_DATA_TYPE, false,
     "UFIXED8_VEC4, UFIXED8_RGBA_SRGB or FLOAT32_VEC4"},
    {ANARI_FRAME, nullptr, "channel.depth", ANARI_DATA_TYPE, false, "FLOAT32"},
    {ANARI_FRAME, nullptr, "frameCompletionCallback", ANARI_FRAME_COMPLETION_CALLBACK, false,
     "is called after each picture"},
    {ANARI_FRAME, nullptr, "frameCompletionCallbackUserData", ANARI_VOID_POINTER, false,
     "first argument of frameCompletionCallback"},

    {ANARI_WORLD, nullptr, "instance", ANARI_ARRAY1D, false, "instances"},
    {ANARI_WORLD, nullptr, "volume", ANARI_ARRAY1D, false, "volumes"},
    {ANARI_WORLD, nullptr, "light", ANARI_ARRAY1D, false, "lights, for renderer lit"},
    {ANARI_WORLD, nullptr, "surface", ANARI_ARRAY1D, false, "not drawn"},
    {ANARI_GROUP, nullptr, "volume", ANARI_ARRAY1D, false, "volumes"},
    {ANARI_GROUP, nullptr, "light", ANARI_ARRAY1D, false, "lights, for renderer lit"},
    {ANARI_GROUP, nullptr, "surface", ANARI_ARRAY1D, false, "not drawn"},
    {ANARI_INSTANCE, nullptr, "group", ANARI_GROUP, true, "what is placed"},
    {ANARI_INSTANCE, nullptr, "transform", ANARI_FLOAT32_MAT4, false,
     "rotation, one scale for all axes, and move"},

    {ANARI_VOLUME, nullptr, "value", ANARI_SPATIAL_FIELD, true, "the field"},
    {ANARI_VOLUME, nullptr, "valueRange", ANARI_FLOAT32_BOX1, false,
     "field values of the first and the last colour"},
#ifdef ANARI_FLOAT64_BOX1 /* newer SDKs */
    {ANARI_VOLUME, nullptr, "valueRange", ANARI_FLOAT64_BOX1, false,
     "field values of the first and the last colour"},
#endif
    {ANARI_VOLUME, nullptr, "color", ANARI_ARRAY1D, true, "colours over valueRange"},
    {ANARI_VOLUME, nullptr, "color", ANARI_FLOAT32_VEC3, true, "one colour"},
    {ANARI_VOLUME, nullptr, "color", ANARI_FLOAT32_VEC4, true, "one colour, with its opacity"},
    {ANARI_VOLUME, nullptr, "opacity", ANARI_ARRAY1D, false,
     "opacities over valueRange, times those of the colours"},
    {ANARI_VOLUME, nullptr, "opacity", ANARI_FLOAT32, false, "one opacity"},
    {ANARI_VOLUME, nullptr, "unitDistance", ANARI_FLOAT32, false,
     "the length that opacities are for"},
    {ANARI_VOLUME, nullptr, "visible", ANARI_BOOL, false, "whether it is drawn"},

    {ANARI_SPATIAL_FIELD, "structuredRegular", "data", ANARI_ARRAY3D, true, "samples"},
    {ANARI_SPATIAL_FIELD, "structuredRegular", "origin", ANARI_FLOAT32_VEC3, false,
     "place of the first sample"},
    {ANARI_SPATIAL_FIELD, "structuredRegular", "spacing", ANARI_FLOAT32_VEC3, false,
     "distances of samples"},
    {ANARI_SPATIAL_FIELD, "structuredRegular", "psnr", ANARI_FLOAT32, false,
     "how exactly samples are compressed, in dB"},
    {ANARI_SPATIAL_FIELD, "cvol", "file", ANARI_STRING, true, "the name of a .cvol file"},
    {ANARI_SPATIAL_FIELD, nullptr, "filter", ANARI_STRING, false, "linear or cubic"},

    {ANARI_RENDERER, nullptr, "background", ANARI_FLOAT32_VEC4, false, "colour and opacity"},
    {ANARI_RENDERER, nullptr, "background", ANARI_ARRAY2D, false, "an image that fills the frame"},

    {ANARI_LIGHT, nullptr, "direction", ANARI_FLOAT32_VEC3, false, "where the light shines"},
    {ANARI_LIGHT, nullptr, "irradiance", ANARI_FLOAT32, false, "0: no light"},
};

static bool is_of(const parameter_fact &f, ANARIDataType type, const char *subtype)
{
    return f.type == type && (!f.subtype || !std::strcmp(f.subtype, subtype));
}

std::string check_parameter(ANARIDataType type, const char *subtype, const char *name,
                            ANARIDataType given)
{
    bool is_known = false;
    for (const parameter_fact &f : facts) {
        if (!is_of(f, type, subtype) || std::strcmp(f.name, name))
            continue;
        if (f.parameter_type == given)
            return "";
        is_known = true;
    }
    return is_known ? std::string(name) + " is of type " + std::to_string(static_cast<int>(given)) +
                          ", which this parameter does not have; it is left out"
                    : "";
}

/* ---- facts for applications ------------------------------------------------------------------ */

/* Lists stay valid, so they are kept, for all devices. */
static const ANARIParameter *list_parameters(ANARIDataType type, const char *subtype)
{
    static std::mutex lock;
    static std::map<std::string, std::vector<ANARIParameter>> kept;
    std::vector<ANARIParameter> list = {{"name", ANARI_STRING}};
    for (const parameter_fact &f : facts)
        if (is_of(f, type, subtype))
            list.push_back({f.name, f.parameter_type});
    list.push_back({nullptr, ANARI_UNKNOWN});
    const std::string key = std::to_string(static_cast<int>(type)) + " " + subtype;
    const std::lock_guard<std::mutex> held(lock);
    return kept.emplace(key, std::move(list)).first->second.data();
}

const void *object_info(ANARIDataType type, const char *subtype, const char *info,
                        ANARIDataType info_type)
{
    if (!std::strcmp(info, "parameter") && info_type == ANARI_PARAMETER_LIST)
        return list_parameters(type, subtype ? subtype : "");
    if (!std::strcmp(info, "extension") && info_type == ANARI_STRING_LIST)
        return extensions();
    if (!std::strcmp(info, "description") && info_type == ANARI_STRING)
        return type_name(type);
    return nullptr;
}

const void *parameter_info(ANARIDataType type, const char *subtype, const char *name,
                           ANARIDataType parameter_type, const char *info, ANARIDataType info_type)
{
    static const int32_t yes = 1, no = 0;
    for (const parameter_fact &f : facts) {
        if (!is_of(f, type, subtype ? subtype : "") || std::strcmp(f.name, name) ||
            f.parameter_type != parameter_type)
            continue;
        if (!std::strcmp(info, "required") && info_type == ANARI_BOOL)
            return f.is_required ? &yes : &no;
        if (!std::strcmp(info, "description") && info_type == ANARI_STRING)
            return f.description;
    }
    return nullptr;
}

} // namespace cvol_anari
