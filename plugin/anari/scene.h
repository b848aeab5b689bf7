/* What a world holds: spatial fields, volumes with their transfer functions, groups, instances. */
#ifndef CVOL_ANARI_SCENE_H
#define CVOL_ANARI_SCENE_H

#include "array.h"
#include "draw.h"

#include <memory>

namespace cvol_anari
{

/* Spatial field structuredRegular, samples in an array; and cvol, a .cvol file. */
class spatial_field : public object
{
  public:
    using object::object;
    void commit() override;
    /* What renderers draw; NULL: nothing. It does not change: a commit makes another one. */
    std::shared_ptr<field> drawn;

  private:
    std::shared_ptr<field> make_from_array();
    std::shared_ptr<field> make_from_file();
};

/* Volume transferFunction1D. */
class volume : public object
{
  public:
    using object::object;
    void commit() override;
    int get_property(const char *name, ANARIDataType type, void *memory, uint64_t size) override;
    bool is_visible() const
    {
        return visible && value && value->drawn && colours;
    }
    reference<spatial_field> value;
    std::shared_ptr<const transfer_function> colours;

  private:
    bool visible = true;
};

class light : public object
{
  public:
    using object::object;
    void commit() override;
    double direction[3] = {0, 0, -1};
    bool shines = false;
};

class group : public object
{
  public:
    using object::object;
    void commit() override;
    int get_property(const char *name, ANARIDataType type, void *memory, uint64_t size) override;
    std::vector<reference<volume>> volumes;
    std::vector<reference<light>> lights;
};

class instance : public object
{
  public:
    using object::object;
    void commit() override;
    int get_property(const char *name, ANARIDataType type, void *memory, uint64_t size) override;
    reference<group> content;
    pose placed;
    bool is_drawable = true; /* 0: its transform has no pose */
};

class world : public group
{
  public:
    using group::group;
    void commit() override;
    int get_property(const char *name, ANARIDataType type, void *memory, uint64_t size) override;
    /* Adds everything that is visible to a drawing. Returns 1 if volumes of it overlap. */
    int collect(drawing &out) const;

  private:
    std::vector<reference<instance>> instances;
};

} // namespace cvol_anari
#endif
