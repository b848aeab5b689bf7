#include "device.h"

#include "queries.h"
#include "types.h"

#include <exception>
#include <new>

namespace cvol_anari
{

typedef std::lock_guard<std::recursive_mutex> guard;

template <typename H> static H handle_of(object *o)
{
    return reinterpret_cast<H>(o);
}

device::device(ANARILibrary library) : anari::DeviceImpl(library)
{
    shared_context = cvol_context_create();
    self = new object(*this, ANARI_DEVICE, "");
    status = defaultStatusCallback();
    status_user = defaultStatusCallbackUserPtr();
}

device::~device()
{
    self->release_for_application();
    cvol_context_free(shared_context);
}

/* The object of a handle; the device itself is one. */
object &device::find(ANARIObject handle)
{
    return handleIsDevice(handle) ? *self : *reinterpret_cast<object *>(handle);
}

void device::report(const object *source, ANARIStatusSeverity severity, ANARIStatusCode code,
                    const std::string &text)
{
    if (!status)
        return;
    const std::string message = "cvol: " + (source ? source->describe() + ": " : "") + text;
    const ANARIObject handle = source == self
                                   ? static_cast<ANARIObject>(this_device())
                                   : handle_of<ANARIObject>(const_cast<object *>(source));
    status(status_user, this_device(), handle, source ? source->type : ANARIDataType(ANARI_DEVICE),
           severity, code, message.c_str());
}

template <typename F> auto device::guarded(const object *about, F work) -> decltype(work())
{
    const guard held(lock);
    try {
        return work();
    } catch (const std::bad_alloc &) {
        report(about, ANARI_SEVERITY_ERROR, ANARI_STATUS_OUT_OF_MEMORY, "there is no memory");
    } catch (const std::exception &e) {
        report(about, ANARI_SEVERITY_ERROR, ANARI_STATUS_UNKNOWN_ERROR, e.what());
    }
    return decltype(work())();
}

/* ---- new objects ---------------------------------------------------------------------------- */

/* Objects of subtypes that are not known take parameters, and draw nothing. */
template <typename T> T *device::make(ANARIDataType type, const char *subtype)
{
    return guarded(nullptr, [&] {
        T *made = new T(*this, type, subtype);
        const char **known = subtypes(type);
        bool is_known = !known[0];
        for (int i = 0; known[i]; i++)
            is_known |= !std::strcmp(known[i], subtype);
        if (!is_known)
            made->report(ANARI_SEVERITY_WARNING, ANARI_STATUS_INVALID_ARGUMENT,
                         "has no such subtype, so it draws nothing");
        return made;
    });
}

object *device::make_array(ANARIDataType type, ANARIDataType element, const uint64_t items[3],
                           const shared_memory &memory)
{
    const guard held(lock);
    const uint64_t bytes = size_of(element);
    const uint64_t most = SIZE_MAX / 2;
    if (bytes == 0 || !items[0] || !items[1] || !items[2] || items[1] > most / items[0] ||
        items[2] > most / items[0] / items[1] || bytes > most / items[0] / items[1] / items[2]) {
        report(nullptr, ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT,
               "an array of " + std::to_string(items[0]) + " x " + std::to_string(items[1]) +
                   " x " + std::to_string(items[2]) + " elements of type " +
                   std::to_string(static_cast<int>(element)) + " is not possible");
        return nullptr;
    }
    try {
        return new array(*this, type, element, items, memory);
    } catch (const std::bad_alloc &) {
        report(nullptr, ANARI_SEVERITY_ERROR, ANARI_STATUS_OUT_OF_MEMORY,
               "there is no memory for an array");
        return nullptr;
    }
}

ANARIArray1D device::newArray1D(const void *memory, ANARIMemoryDeleter deleter, const void *user,
                                ANARIDataType element, uint64_t items1)
{
    const uint64_t items[3] = {items1, 1, 1};
    return handle_of<ANARIArray1D>(
        make_array(ANARI_ARRAY1D, element, items, {memory, deleter, user}));
}

ANARIArray2D device::newArray2D(const void *memory, ANARIMemoryDeleter deleter, const void *user,
                                ANARIDataType element, uint64_t items1, uint64_t items2)
{
    const uint64_t items[3] = {items1, items2, 1};
    return handle_of<ANARIArray2D>(
        make_array(ANARI_ARRAY2D, element, items, {memory, deleter, user}));
}

ANARIArray3D device::newArray3D(const void *memory, ANARIMemoryDeleter deleter, const void *user,
                                ANARIDataType element, uint64_t items1, uint64_t items2,
                                uint64_t items3)
{
    const uint64_t items[3] = {items1, items2, items3};
    return handle_of<ANARIArray3D>(
        make_array(ANARI_ARRAY3D, element, items, {memory, deleter, user}));
}

ANARIGeometry device::newGeometry(const char *subtype)
{
    return handle_of<ANARIGeometry>(make<object>(ANARI_GEOMETRY, subtype));
}

ANARIMaterial device::newMaterial(const char *subtype)
{
    return handle_of<ANARIMaterial>(make<object>(ANARI_MATERIAL, subtype));
}

ANARISampler device::newSampler(const char *subtype)
{
    return handle_of<ANARISampler>(make<object>(ANARI_SAMPLER, subtype));
}

ANARISurface device::newSurface()
{
    return handle_of<ANARISurface>(make<object>(ANARI_SURFACE, ""));
}

ANARISpatialField device::newSpatialField(const char *subtype)
{
    return handle_of<ANARISpatialField>(make<spatial_field>(ANARI_SPATIAL_FIELD, subtype));
}

ANARIVolume device::newVolume(const char *subtype)
{
    return handle_of<ANARIVolume>(make<volume>(ANARI_VOLUME, subtype));
}

ANARILight device::newLight(const char *subtype)
{
    return handle_of<ANARILight>(make<light>(ANARI_LIGHT, subtype));
}

ANARIGroup device::newGroup()
{
    return handle_of<ANARIGroup>(make<group>(ANARI_GROUP, ""));
}

ANARIInstance device::newInstance(const char *subtype)
{
    return handle_of<ANARIInstance>(make<instance>(ANARI_INSTANCE, subtype));
}

ANARIWorld device::newWorld()
{
    return handle_of<ANARIWorld>(make<world>(ANARI_WORLD, ""));
}

ANARICamera device::newCamera(const char *subtype)
{
    return handle_of<ANARICamera>(make<camera>(ANARI_CAMERA, subtype));
}

ANARIRenderer device::newRenderer(const char *subtype)
{
    return handle_of<ANARIRenderer>(make<renderer>(ANARI_RENDERER, subtype));
}

ANARIFrame device::newFrame()
{
    return handle_of<ANARIFrame>(make<frame>(ANARI_FRAME, ""));
}

/* ---- parameters ------------------------------------------------------------------------------ */

void device::setParameter(ANARIObject handle, const char *name, ANARIDataType type,
                          const void *memory)
{
    object &o = find(handle);
    guarded(&o, [&] {
        if (type != ANARI_STRING && size_of(type) == 0)
            return o.report(ANARI_SEVERITY_WARNING, ANARI_STATUS_INVALID_ARGUMENT,
                            std::string(name) + " is of type " +
                                std::to_string(static_cast<int>(type)) +
                                ", which no parameter has");
        const std::string wrong = check_parameter(o.type, o.subtype.c_str(), name, type);
        if (!wrong.empty())
            o.report(ANARI_SEVERITY_WARNING, ANARI_STATUS_INVALID_ARGUMENT, wrong);
        o.set(name, type, memory);
    });
}

void device::unsetParameter(ANARIObject handle, const char *name)
{
    const guard held(lock);
    find(handle).unset(name);
}

void device::unsetAllParameters(ANARIObject handle)
{
    const guard held(lock);
    find(handle).unset_all();
}

/* A new array becomes the parameter, which holds the only reference to it. */
void *device::map_parameter(ANARIObject handle, const char *name, ANARIDataType type,
                            ANARIDataType element, const uint64_t items[3], uint64_t *stride)
{
    const guard held(lock);
    object *made = make_array(type, element, items, {});
    *stride = size_of(element);
    if (!made)
        return nullptr;
    setParameter(handle, name, type, &made);
    void *data = static_cast<array *>(made)->map();
    const bool is_set = find(handle).get_object(name, type) == made;
    made->release_for_application(); /* frees an array that did not become the parameter */
    return is_set ? data : nullptr;
}

void *device::mapParameterArray1D(ANARIObject handle, const char *name, ANARIDataType element,
                                  uint64_t items1, uint64_t *stride)
{
    const uint64_t items[3] = {items1, 1, 1};
    return map_parameter(handle, name, ANARI_ARRAY1D, element, items, stride);
}

void *device::mapParameterArray2D(ANARIObject handle, const char *name, ANARIDataType element,
                                  uint64_t items1, uint64_t items2, uint64_t *stride)
{
    const uint64_t items[3] = {items1, items2, 1};
    return map_parameter(handle, name, ANARI_ARRAY2D, element, items, stride);
}

void *device::mapParameterArray3D(ANARIObject handle, const char *name, ANARIDataType element,
                                  uint64_t items1, uint64_t items2, uint64_t items3,
                                  uint64_t *stride)
{
    const uint64_t items[3] = {items1, items2, items3};
    return map_parameter(handle, name, ANARI_ARRAY3D, element, items, stride);
}

void device::unmapParameterArray(ANARIObject handle, const char *name)
{
    object &of = find(handle);
    guarded(&of, [&] {
        for (const ANARIDataType type : {ANARI_ARRAY1D, ANARI_ARRAY2D, ANARI_ARRAY3D})
            if (object *o = of.get_object(name, type))
                static_cast<array *>(o)->unmap();
    });
}

void device::commitParameters(ANARIObject handle)
{
    object &o = find(handle);
    guarded(&o, [&] {
        o.commit();
        if (&o != self)
            return;
        status = self->get("statusCallback", ANARI_STATUS_CALLBACK, defaultStatusCallback());
        status_user = self->get("statusCallbackUserData", ANARI_VOID_POINTER,
                                defaultStatusCallbackUserPtr());
    });
}

void device::retain(ANARIObject handle)
{
    const guard held(lock);
    if (!handle)
        return;
    if (handleIsDevice(handle))
        references++;
    else
        find(handle).retain_for_application();
}

/* A frame ends its thread before the lock is taken, which its completion callback may wait for. */
void device::end_frame(object &o)
{
    if (o.type != ANARI_FRAME || !o.is_last())
        return;
    auto &f = static_cast<frame &>(o);
    f.discard();
    f.end_thread();
}

void device::release(ANARIObject handle)
{
    bool is_last = false;
    if (!handle)
        return;
    end_frame(find(handle));
    guarded(nullptr, [&] {
        if (handleIsDevice(handle))
            is_last = --references == 0;
        else
            find(handle).release_for_application();
    });
    if (is_last)
        delete this;
}

void *device::mapArray(ANARIArray handle)
{
    const guard held(lock);
    return static_cast<array &>(find(handle)).map();
}

void device::unmapArray(ANARIArray handle)
{
    array &a = static_cast<array &>(find(handle));
    guarded(&a, [&] { a.unmap(); });
}

/* ---- properties ------------------------------------------------------------------------------ */

static int get_device_property(const char *name, ANARIDataType type, void *memory, uint64_t size)
{
    const struct {
        const char *name;
        int32_t value;
    } numbers[] = {
        {"version", CVOL_VERSION_MAJOR * 10000 + CVOL_VERSION_MINOR * 100 + CVOL_VERSION_PATCH},
        {"version.major", CVOL_VERSION_MAJOR},
        {"version.minor", CVOL_VERSION_MINOR},
        {"version.patch", CVOL_VERSION_PATCH}};
    for (const auto &n : numbers)
        if (!std::strcmp(n.name, name) && type == ANARI_INT32 && size >= sizeof n.value) {
            std::memcpy(memory, &n.value, sizeof n.value);
            return 1;
        }
    const uint64_t most = 0; /* of a geometry: there are none */
    if (!std::strcmp(name, "geometryMaxIndex") && type == ANARI_UINT64 && size >= sizeof most) {
        std::memcpy(memory, &most, sizeof most);
        return 1;
    }
    const char **list = extensions();
    if (!std::strcmp(name, "extension") && type == ANARI_STRING_LIST && size >= sizeof list) {
        std::memcpy(memory, &list, sizeof list);
        return 1;
    }
    return 0;
}

int device::getProperty(ANARIObject handle, const char *name, ANARIDataType type, void *memory,
                        uint64_t size, ANARIWaitMask mask)
{
    if (handleIsDevice(handle))
        return get_device_property(name, type, memory, size);
    object &o = find(handle);
    if (o.type == ANARI_FRAME && mask == ANARI_WAIT)
        static_cast<frame &>(o).is_ready(true);
    return guarded(&o, [&] { return o.get_property(name, type, memory, size); });
}

const char **device::getObjectSubtypes(ANARIDataType type)
{
    return subtypes(type);
}

const void *device::getObjectInfo(ANARIDataType type, const char *subtype, const char *info,
                                  ANARIDataType info_type)
{
    return guarded(nullptr, [&] { return object_info(type, subtype, info, info_type); });
}

const void *device::getParameterInfo(ANARIDataType type, const char *subtype, const char *parameter,
                                     ANARIDataType parameter_type, const char *info,
                                     ANARIDataType info_type)
{
    return parameter_info(type, subtype, parameter, parameter_type, info, info_type);
}

/* ---- frames ---------------------------------------------------------------------------------- */

/* The lock is not held while a picture is being drawn, so that callbacks can use the device. */
const void *device::frameBufferMap(ANARIFrame handle, const char *channel, uint32_t *width,
                                   uint32_t *height, ANARIDataType *type)
{
    auto &f = static_cast<frame &>(find(handle));
    f.is_ready(true);
    return guarded(&f, [&] { return f.map(channel, width, height, type); });
}

void device::frameBufferUnmap(ANARIFrame, const char *)
{
}

void device::renderFrame(ANARIFrame handle)
{
    auto &f = static_cast<frame &>(find(handle));
    f.is_ready(true);
    f.end_thread();
    guarded(&f, [&] { f.render(); });
}

int device::frameReady(ANARIFrame handle, ANARIWaitMask mask)
{
    return static_cast<frame &>(find(handle)).is_ready(mask == ANARI_WAIT);
}

void device::discardFrame(ANARIFrame handle)
{
    const guard held(lock);
    static_cast<frame &>(find(handle)).discard();
}

} // namespace cvol_anari
