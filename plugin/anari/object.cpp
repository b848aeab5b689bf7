#include "object.h"

#include "host.h"
#include "types.h"

namespace cvol_anari
{

object::object(host &owner, ANARIDataType type, std::string subtype)
    : owner(owner), type(type), subtype(std::move(subtype))
{
}

void object::release_for_application()
{
    if (application_references == 0)
        return;
    application_references--;
    if (application_references == 0 && references == 0)
        delete this;
    else if (application_references == 0)
        leave_application();
}

void object::release()
{
    references--;
    if (references == 0 && application_references == 0)
        delete this;
}

void object::set(const char *name, ANARIDataType type, const void *memory)
{
    parameter p;
    p.type = type;
    if (type == ANARI_STRING) {
        const char *text = static_cast<const char *>(memory);
        p.bytes.assign(text, text + std::strlen(text) + 1);
    } else if (is_object(type)) {
        object *target;
        std::memcpy(&target, memory, sizeof target);
        p.target = target;
    } else {
        const auto *bytes = static_cast<const unsigned char *>(memory);
        p.bytes.assign(bytes, bytes + size_of(type));
    }
    parameters[name] = std::move(p);
}

const void *object::find(const char *name, ANARIDataType type) const
{
    const auto at = parameters.find(name);
    return at != parameters.end() && at->second.type == type && !at->second.bytes.empty()
               ? at->second.bytes.data()
               : nullptr;
}

std::string object::get_text(const char *name, const char *otherwise) const
{
    const void *bytes = find(name, ANARI_STRING);
    return bytes ? static_cast<const char *>(bytes) : otherwise;
}

object *object::get_object(const char *name, ANARIDataType type) const
{
    const auto at = parameters.find(name);
    if (at == parameters.end() || !at->second.target)
        return nullptr;
    object *target = at->second.target.get();
    return target->type == type ? target : nullptr;
}

int object::get_property(const char *, ANARIDataType, void *, uint64_t)
{
    return 0;
}

void object::report(ANARIStatusSeverity severity, ANARIStatusCode code, const std::string &text)
{
    owner.report(this, severity, code, text);
}

std::string object::describe() const
{
    std::string text = type_name(type);
    if (!subtype.empty())
        text += " " + subtype;
    const std::string name = get_text("name", "");
    return name.empty() ? text : text + " '" + name + "'";
}

} // namespace cvol_anari
