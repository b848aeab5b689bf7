/* Objects of the device: reference counts and parameters. */
#ifndef CVOL_ANARI_OBJECT_H
#define CVOL_ANARI_OBJECT_H

#include <anari/anari.h>

#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace cvol_anari
{

class host;

/* An object of the scene. Handles of the API point to it. It lives as long as the application or
 * another object refers to it. One thread at a time may use the objects of a device. */
class object
{
  public:
    object(host &owner, ANARIDataType type, std::string subtype);
    virtual ~object() = default;
    object(const object &) = delete;
    object &operator=(const object &) = delete;

    void retain_for_application()
    {
        application_references++;
    }
    void release_for_application();
    /* 1 if the next release by the application frees the object. */
    bool is_last() const
    {
        return application_references == 1 && references == 0;
    }
    void retain()
    {
        references++;
    }
    void release();

    void set(const char *name, ANARIDataType type, const void *memory);
    void unset(const char *name)
    {
        parameters.erase(name);
    }
    void unset_all()
    {
        parameters.clear();
    }

    /* Parameters take effect. */
    virtual void commit()
    {
    }
    /* Copies a property to `memory` of `size` bytes; returns 0 if there is none. */
    virtual int get_property(const char *name, ANARIDataType type, void *memory, uint64_t size);

    /* The bytes of a parameter of one of the types, or NULL. */
    const void *find(const char *name, ANARIDataType type) const;
    template <typename T> T get(const char *name, ANARIDataType type, const T &otherwise) const
    {
        T out = otherwise;
        const void *bytes = find(name, type);
        if (bytes)
            std::memcpy(&out, bytes, sizeof out);
        return out;
    }
    std::string get_text(const char *name, const char *otherwise) const;
    /* The object of a parameter, or NULL. */
    object *get_object(const char *name, ANARIDataType type) const;

    /* Sends a message to the application, about this object. */
    void report(ANARIStatusSeverity severity, ANARIStatusCode code, const std::string &text);
    /* "camera perspective", for messages. */
    std::string describe() const;

    host &owner;
    const ANARIDataType type;
    const std::string subtype;

  protected:
    /* The application has no reference left, but other objects do. */
    virtual void leave_application()
    {
    }

  private:
    struct parameter;
    std::map<std::string, parameter> parameters;
    int application_references = 1, references = 0;
};

/* A reference that keeps its object alive. */
template <typename T> class reference
{
  public:
    reference() = default;
    reference(T *to) : to(to)
    {
        hold();
    }
    reference(const reference &other) : to(other.to)
    {
        hold();
    }
    reference &operator=(reference other)
    {
        std::swap(to, other.to);
        return *this;
    }
    ~reference()
    {
        if (to)
            to->release();
    }
    T *get() const
    {
        return to;
    }
    T *operator->() const
    {
        return to;
    }
    explicit operator bool() const
    {
        return to != nullptr;
    }

  private:
    void hold()
    {
        if (to)
            to->retain();
    }
    T *to = nullptr;
};

struct object::parameter {
    ANARIDataType type = ANARI_UNKNOWN;
    std::vector<unsigned char> bytes; /* of a text: with its final 0 */
    reference<object> target;         /* if the type is that of an object */
};

} // namespace cvol_anari
#endif
