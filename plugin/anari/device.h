/* The device: handles of the API to objects, messages, and what can be asked. */
#ifndef CVOL_ANARI_DEVICE_H
#define CVOL_ANARI_DEVICE_H

#include "frame.h"
#include "host.h"

#include <anari/backend/DeviceImpl.h>

namespace cvol_anari
{

class device : public anari::DeviceImpl, public host
{
  public:
    explicit device(ANARILibrary library);
    ~device() override;

    void report(const object *source, ANARIStatusSeverity severity, ANARIStatusCode code,
                const std::string &text) override;
    cvol_context *context() override
    {
        return shared_context;
    }
    ANARIDevice handle() const override
    {
        return this_device();
    }

    ANARIArray1D newArray1D(const void *memory, ANARIMemoryDeleter deleter, const void *user,
                            ANARIDataType element, uint64_t items1) override;
    ANARIArray2D newArray2D(const void *memory, ANARIMemoryDeleter deleter, const void *user,
                            ANARIDataType element, uint64_t items1, uint64_t items2) override;
    ANARIArray3D newArray3D(const void *memory, ANARIMemoryDeleter deleter, const void *user,
                            ANARIDataType element, uint64_t items1, uint64_t items2,
                            uint64_t items3) override;
    ANARIGeometry newGeometry(const char *subtype) override;
    ANARIMaterial newMaterial(const char *subtype) override;
    ANARISampler newSampler(const char *subtype) override;
    ANARISurface newSurface() override;
    ANARISpatialField newSpatialField(const char *subtype) override;
    ANARIVolume newVolume(const char *subtype) override;
    ANARILight newLight(const char *subtype) override;
    ANARIGroup newGroup() override;
    ANARIInstance newInstance(const char *subtype) override;
    ANARIWorld newWorld() override;
    ANARICamera newCamera(const char *subtype) override;
    ANARIRenderer newRenderer(const char *subtype) override;
    ANARIFrame newFrame() override;

    void setParameter(ANARIObject handle, const char *name, ANARIDataType type,
                      const void *memory) override;
    void unsetParameter(ANARIObject handle, const char *name) override;
    void unsetAllParameters(ANARIObject handle) override;
    void *mapParameterArray1D(ANARIObject handle, const char *name, ANARIDataType element,
                              uint64_t items1, uint64_t *stride) override;
    void *mapParameterArray2D(ANARIObject handle, const char *name, ANARIDataType element,
                              uint64_t items1, uint64_t items2, uint64_t *stride) override;
    void *mapParameterArray3D(ANARIObject handle, const char *name, ANARIDataType element,
                              uint64_t items1, uint64_t items2, uint64_t items3,
                              uint64_t *stride) override;
    void unmapParameterArray(ANARIObject handle, const char *name) override;
    void commitParameters(ANARIObject handle) override;
    void release(ANARIObject handle) override;
    void retain(ANARIObject handle) override;
    void *mapArray(ANARIArray handle) override;
    void unmapArray(ANARIArray handle) override;
    int getProperty(ANARIObject handle, const char *name, ANARIDataType type, void *memory,
                    uint64_t size, ANARIWaitMask mask) override;

    const char **getObjectSubtypes(ANARIDataType type) override;
    const void *getObjectInfo(ANARIDataType type, const char *subtype, const char *info,
                              ANARIDataType info_type) override;
    const void *getParameterInfo(ANARIDataType type, const char *subtype, const char *parameter,
                                 ANARIDataType parameter_type, const char *info,
                                 ANARIDataType info_type) override;

    const void *frameBufferMap(ANARIFrame handle, const char *channel, uint32_t *width,
                               uint32_t *height, ANARIDataType *type) override;
    void frameBufferUnmap(ANARIFrame handle, const char *channel) override;
    void renderFrame(ANARIFrame handle) override;
    int frameReady(ANARIFrame handle, ANARIWaitMask mask) override;
    void discardFrame(ANARIFrame handle) override;

  private:
    /* The result of `work`, with the lock held. Exceptions do not leave the API: they become
     * messages about an object or (NULL) the device, and the result is 0. */
    template <typename F> auto guarded(const object *about, F work) -> decltype(work());
    object &find(ANARIObject handle);
    void end_frame(object &o);
    template <typename T> T *make(ANARIDataType type, const char *subtype);
    object *make_array(ANARIDataType type, ANARIDataType element, const uint64_t items[3],
                       const shared_memory &memory);
    void *map_parameter(ANARIObject handle, const char *name, ANARIDataType type,
                        ANARIDataType element, const uint64_t items[3], uint64_t *stride);

    std::recursive_mutex lock; /* completion callbacks call from the threads of frames */
    cvol_context *shared_context = nullptr;
    object *self = nullptr; /* the device as an object with parameters */
    int references = 1;
    ANARIStatusCallback status = nullptr;
    const void *status_user = nullptr;
};

} // namespace cvol_anari
#endif
