/* libanari_library_cvol.so: the library that applications of ANARI load by the name cvol. */
#include "device.h"
#include "queries.h"

#include <anari/backend/LibraryImpl.h>

#include <new>

namespace
{

struct library : public anari::LibraryImpl {
    using anari::LibraryImpl::LibraryImpl;
    ANARIDevice newDevice(const char *) override
    {
        try {
            return (new cvol_anari::device(this_library()))->this_device();
        } catch (const std::bad_alloc &) {
            return nullptr;
        }
    }
    const char **getDeviceExtensions(const char *) override
    {
        return cvol_anari::extensions();
    }
};

} // namespace

extern "C" __attribute__((visibility("default")))
ANARI_DEFINE_LIBRARY_ENTRYPOINT(cvol, handle, status, user)
{
    return (new library(handle, status, user))->this_library();
}
