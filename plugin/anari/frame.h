/* Cameras, renderers and frames. */
#ifndef CVOL_ANARI_FRAME_H
#define CVOL_ANARI_FRAME_H

#include "scene.h"

#include <atomic>
#include <condition_variable>
#include <thread>

namespace cvol_anari
{

/* Cameras perspective and orthographic. */
class camera : public object
{
  public:
    using object::object;
    void commit() override;
    camera_state state;
};

/* Renderers default and lit. */
class renderer : public object
{
  public:
    using object::object;
    void commit() override;
    float background[4] = {0, 0, 0, 1};
    reference<array> background_image; /* over all of the frame; NULL: one colour */
};

/* A frame draws in a thread of its own. */
class frame : public object
{
  public:
    using object::object;
    ~frame() override;
    void commit() override;
    int get_property(const char *name, ANARIDataType type, void *memory, uint64_t size) override;

    /* Waits for the thread and its callback, which may wait for the lock of the device: the caller
     * does not hold it. */
    void end_thread();
    /* Starts a picture. The last one is done, and its thread ended. */
    void render();
    /* Without `wait`: 1 if no picture is being drawn. */
    int is_ready(bool wait);
    void discard();
    const void *map(const char *channel, uint32_t *width, uint32_t *height, ANARIDataType *type);

  private:
    struct job;
    void tell_failure();
    void convert(const job &done);
    reference<world> shown;
    reference<camera> eye;
    reference<renderer> by;
    uint32_t size[2] = {0, 0};
    ANARIDataType colour_type = ANARI_UNKNOWN, depth_type = ANARI_UNKNOWN;
    ANARIFrameCompletionCallback completed = nullptr;
    const void *completed_user = nullptr;

    std::shared_ptr<job> current; /* the last picture */
    std::thread worker;
    bool is_converted = false, has_warned = false;
    std::vector<unsigned char> colours;
    std::vector<float> depths;
};

} // namespace cvol_anari
#endif
