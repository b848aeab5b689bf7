/* Arrays of elements in memory of the application or of the device. */
#ifndef CVOL_ANARI_ARRAY_H
#define CVOL_ANARI_ARRAY_H

#include "object.h"

namespace cvol_anari
{

/* What the application says about its memory; without memory the device allocates it. */
struct shared_memory {
    const void *data = nullptr;
    ANARIMemoryDeleter deleter = nullptr;
    const void *user = nullptr;
};

class array : public object
{
  public:
    array(host &owner, ANARIDataType type, ANARIDataType element, const uint64_t items[3],
          const shared_memory &memory);
    ~array() override;

    void *map();
    void unmap();

    const void *data() const
    {
        return shared.data ? shared.data : own.data();
    }
    /* The objects of an array of handles. */
    std::vector<object *> objects() const;
    /* Element i as a colour, components of 0 to 1 up to rounding; alpha is 1 if there is none.
     * Returns 0 if the elements are no colours. */
    int get_colour(double rgba[4], uint64_t i) const;

    const ANARIDataType element;
    uint64_t items[3]; /* 0: its elements are lost */
    uint64_t count() const
    {
        return items[0] * items[1] * items[2];
    }

  protected:
    void leave_application() override;

  private:
    void hold_objects();
    void free_shared();
    shared_memory shared;
    std::vector<unsigned char> own;
    std::vector<reference<object>> held;
};

} // namespace cvol_anari
#endif
