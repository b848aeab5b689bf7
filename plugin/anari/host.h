/* What objects need of the device that they belong to. */
#ifndef CVOL_ANARI_HOST_H
#define CVOL_ANARI_HOST_H

#include <anari/anari.h>
#include <cvol/cvol.h>

#include <string>

namespace cvol_anari
{

class object;

class host
{
  public:
    virtual ~host() = default;
    /* Sends a message to the application, about an object or (NULL) the device. */
    virtual void report(const object *source, ANARIStatusSeverity severity, ANARIStatusCode code,
                        const std::string &text) = 0;
    /* For calls in the thread of the application. */
    virtual cvol_context *context() = 0;
    virtual ANARIDevice handle() const = 0;
};

} // namespace cvol_anari
#endif
