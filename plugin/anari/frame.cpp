#include "frame.h"

#include "host.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <new>

namespace cvol_anari
{

/* ---- cameras --------------------------------------------------------------------------------- */

static bool normalise(double v[3])
{
    const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0) || !std::isfinite(length))
        return false;
    for (int a = 0; a < 3; a++)
        v[a] /= length;
    return true;
}

static void get_vector(double out[3], const object &from, const char *name)
{
    const void *given = from.find(name, ANARI_FLOAT32_VEC3);
    for (int a = 0; given && a < 3; a++)
        out[a] = static_cast<const float *>(given)[a];
}

/* Makes `up` a unit vector across the direction; false if there is none. */
static bool turn_up(double up[3], const double direction[3])
{
    const double along = up[0] * direction[0] + up[1] * direction[1] + up[2] * direction[2];
    for (int a = 0; a < 3; a++)
        up[a] -= along * direction[a];
    return normalise(up);
}

void camera::commit()
{
    camera_state s;
    s.is_parallel = subtype == "orthographic";
    get_vector(s.position, *this, "position");
    get_vector(s.direction, *this, "direction");
    get_vector(s.up, *this, "up");
    s.fovy = static_cast<double>(get("fovy", ANARI_FLOAT32, static_cast<float>(s.fovy)));
    s.height = static_cast<double>(get("height", ANARI_FLOAT32, 1.0f));
    s.aspect = static_cast<double>(get("aspect", ANARI_FLOAT32, 1.0f));
    const void *region = find("imageRegion", ANARI_FLOAT32_BOX2);
    for (int i = 0; region && i < 4; i++)
        s.region[i] = static_cast<const float *>(region)[i];
    const char *wrong = !normalise(s.direction) ? "direction must not be 0 0 0"
                        : !turn_up(s.up, s.direction)
                            ? "up must be another direction than direction"
                        : !(s.aspect > 0)                      ? "aspect must be above 0"
                        : s.is_parallel && !(s.height > 0)     ? "height must be above 0"
                        : !(s.fovy > 0 && s.fovy < 3.14159265) ? "fovy must be above 0 and below pi"
                        : !(s.region[2] > s.region[0] && s.region[3] > s.region[1])
                            ? "imageRegion must not be empty"
                            : nullptr;
    if (wrong)
        report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT, wrong);
    else
        state = s;
}

/* ---- renderers ------------------------------------------------------------------------------- */

void renderer::commit()
{
    static const float black[4] = {0, 0, 0, 1};
    const void *colour = find("background", ANARI_FLOAT32_VEC4);
    std::memcpy(background, colour ? colour : black, sizeof background);
    background_image = static_cast<array *>(get_object("background", ANARI_ARRAY2D));
}

/* ---- a picture that is being drawn ----------------------------------------------------------- */

/* The frame and its thread share a job: the thread writes `result` and `message` until is_done. */
struct frame::job {
    drawing scene;
    std::vector<float> background; /* four numbers for each pixel, or four for all */
    pixels result;
    std::string message;
    float seconds = 0;
    std::atomic<bool> is_discarded{false};
    std::atomic<float> share{0}; /* that is drawn */
    std::mutex lock;
    std::condition_variable changed;
    bool is_done = false;

    void run();
    static int follow(void *user, const char *what, double fraction);
};

int frame::job::follow(void *user, const char *, double fraction)
{
    job *self = static_cast<job *>(user);
    self->share = static_cast<float>(fraction);
    return self->is_discarded;
}

void frame::job::run()
{
    const auto start = std::chrono::steady_clock::now();
    cvol_context *context = cvol_context_create();
    if (context) {
        cvol_context_set_progress(context, follow, this);
        try {
            message = draw(context, &result, scene);
        } catch (const std::bad_alloc &) {
            message = "there is no memory for a picture of this size";
        } catch (const std::exception &e) {
            message = e.what();
        }
        cvol_context_free(context);
    } else
        message = "there is no memory";
    seconds = std::chrono::duration<float>(std::chrono::steady_clock::now() - start).count();
    const std::lock_guard<std::mutex> guard(lock);
    is_done = true;
    changed.notify_all();
}

/* ---- frames ---------------------------------------------------------------------------------- */

frame::~frame()
{
    discard();
    end_thread();
}

void frame::end_thread()
{
    if (worker.get_id() == std::this_thread::get_id())
        worker.detach(); /* its own completion callback calls */
    else if (worker.joinable())
        worker.join();
}

static ANARIDataType get_type(object &from, const char *name,
                              std::initializer_list<ANARIDataType> allowed)
{
    const ANARIDataType type = from.get(name, ANARI_DATA_TYPE, ANARIDataType(ANARI_UNKNOWN));
    if (type == ANARI_UNKNOWN || std::find(allowed.begin(), allowed.end(), type) != allowed.end())
        return type;
    from.report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT,
                std::string(name) + " is of type " + std::to_string(static_cast<int>(type)) +
                    ", which frames do not have");
    return ANARI_UNKNOWN;
}

void frame::commit()
{
    shown = static_cast<world *>(get_object("world", ANARI_WORLD));
    eye = static_cast<camera *>(get_object("camera", ANARI_CAMERA));
    by = static_cast<renderer *>(get_object("renderer", ANARI_RENDERER));
    const void *given = find("size", ANARI_UINT32_VEC2);
    for (int i = 0; i < 2; i++)
        size[i] = given ? static_cast<const uint32_t *>(given)[i] : 0;
    colour_type = get_type(*this, "channel.color",
                           {ANARI_UFIXED8_VEC4, ANARI_UFIXED8_RGBA_SRGB, ANARI_FLOAT32_VEC4});
    depth_type = get_type(*this, "channel.depth", {ANARI_FLOAT32});
    completed = get("frameCompletionCallback", ANARI_FRAME_COMPLETION_CALLBACK,
                    ANARIFrameCompletionCallback());
    completed_user = get("frameCompletionCallbackUserData", ANARI_VOID_POINTER,
                         static_cast<const void *>(nullptr));
}

/* Pixel (x, y) of a background image that fills a frame; linear between its pixels. */
static void sample_background(float out[4], const array &image, double x, double y)
{
    const double u = std::clamp(x * static_cast<double>(image.items[0]) - 0.5, 0.0,
                                static_cast<double>(image.items[0] - 1));
    const double v = std::clamp(y * static_cast<double>(image.items[1]) - 0.5, 0.0,
                                static_cast<double>(image.items[1] - 1));
    const auto left = static_cast<uint64_t>(u), low = static_cast<uint64_t>(v);
    double sum[4] = {0, 0, 0, 0};
    for (uint64_t corner = 0; corner < 4; corner++) {
        const uint64_t i = std::min(left + (corner & 1), image.items[0] - 1);
        const uint64_t j = std::min(low + (corner >> 1), image.items[1] - 1);
        const double a = corner & 1 ? u - static_cast<double>(left)
                                    : 1 - (u - static_cast<double>(left));
        const double b = corner >> 1 ? v - static_cast<double>(low)
                                     : 1 - (v - static_cast<double>(low));
        double rgba[4] = {0, 0, 0, 1};
        image.get_colour(rgba, j * image.items[0] + i);
        for (int c = 0; c < 4; c++)
            sum[c] += a * b * rgba[c];
    }
    for (int c = 0; c < 4; c++)
        out[c] = static_cast<float>(sum[c]);
}

static std::vector<float> make_background(const renderer &r, const uint32_t size[2])
{
    if (!r.background_image || !r.background_image->count())
        return std::vector<float>(r.background, r.background + 4);
    std::vector<float> out(static_cast<size_t>(size[0]) * size[1] * 4);
    for (uint32_t y = 0; y < size[1]; y++)
        for (uint32_t x = 0; x < size[0]; x++)
            sample_background(&out[4 * (static_cast<size_t>(y) * size[0] + x)],
                              *r.background_image.get(), (x + 0.5) / size[0], (y + 0.5) / size[1]);
    return out;
}

void frame::render()
{
    tell_failure();
    const char *missing = !shown                 ? "world"
                          : !eye                 ? "camera"
                          : !by                  ? "renderer"
                          : !size[0] || !size[1] ? "size"
                                                 : nullptr;
    if (missing) {
        report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_OPERATION,
               std::string(missing) + " is missing, so there is no picture");
        return;
    }
    auto next = std::make_shared<job>();
    next->scene.camera = eye->state;
    next->scene.width = size[0];
    next->scene.height = size[1];
    next->scene.is_lit = by->subtype == "lit";
    next->background = make_background(*by.get(), size);
    if (shown->collect(next->scene) && !has_warned) {
        has_warned = true;
        report(ANARI_SEVERITY_WARNING, ANARI_STATUS_INVALID_OPERATION,
               "volumes overlap; cvol draws the one with the nearer centre in front of the other");
    }
    const ANARIFrameCompletionCallback callback = completed;
    const void *user = completed_user;
    const ANARIDevice handle = owner.handle();
    const auto self = reinterpret_cast<ANARIFrame>(static_cast<object *>(this));
    const std::shared_ptr<job> last = current;
    current = next; /* before its thread starts, whose callback may map it */
    try {
        worker = std::thread([next, callback, user, handle, self] {
            next->run();
            if (callback && !next->is_discarded)
                callback(user, handle, self);
        });
        is_converted = false;
    } catch (const std::exception &e) {
        current = last; /* waiting for `next` would never end */
        report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_OPERATION,
               std::string("cannot start a thread that draws: ") + e.what());
    }
}

/* Says what went wrong with the last picture, once. */
void frame::tell_failure()
{
    if (!current || current->message.empty())
        return;
    if (!current->is_discarded)
        report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_OPERATION, current->message);
    current->message.clear();
}

int frame::is_ready(bool wait)
{
    const std::shared_ptr<job> last = current;
    if (!last)
        return 1;
    std::unique_lock<std::mutex> guard(last->lock);
    if (wait)
        last->changed.wait(guard, [&] { return last->is_done; });
    return last->is_done;
}

void frame::discard()
{
    if (current)
        current->is_discarded = true;
}

/* ---- channels -------------------------------------------------------------------------------- */

static float encode_srgb(float v)
{
    return v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
}

static unsigned char to_byte(float v)
{
    return static_cast<unsigned char>(std::lrintf(255 * std::clamp(v, 0.0f, 1.0f)));
}

/* The picture over the background, colours not multiplied by alpha. Filters of the renderer may
 * overshoot. */
static void blend(float out[4], const float rgba[4], const float background[4])
{
    const float opacity = std::clamp(rgba[3], 0.0f, 1.0f), rest = (1 - opacity) * background[3];
    out[3] = opacity + rest;
    for (int c = 0; c < 3; c++)
        out[c] = out[3] > 0 ? std::clamp((rgba[c] + rest * background[c]) / out[3], 0.0f, 1.0f)
                            : background[c];
}

void frame::convert(const job &done)
{
    const size_t count = done.result.depth.size();
    const bool is_float = colour_type == ANARI_FLOAT32_VEC4;
    const bool is_srgb = colour_type == ANARI_UFIXED8_RGBA_SRGB;
    const size_t stride = done.background.size() > 4 ? 4 : 0;
    colours.resize(colour_type == ANARI_UNKNOWN ? 0 : count * (is_float ? 16 : 4));
    for (size_t i = 0; i < count && !colours.empty(); i++) {
        float pixel[4];
        blend(pixel, &done.result.rgba[4 * i], &done.background[stride * i]);
        if (is_float)
            std::memcpy(&colours[16 * i], pixel, sizeof pixel);
        for (size_t c = 0; c < 4 && !is_float; c++)
            colours[4 * i + c] = to_byte(is_srgb && c < 3 ? encode_srgb(std::max(pixel[c], 0.0f))
                                                          : pixel[c]);
    }
    depths = depth_type == ANARI_UNKNOWN ? std::vector<float>() : done.result.depth;
    is_converted = true;
}

const void *frame::map(const char *channel, uint32_t *width, uint32_t *height, ANARIDataType *type)
{
    *width = *height = 0;
    *type = ANARI_UNKNOWN;
    tell_failure();
    if (!current || current->is_discarded || current->result.depth.empty())
        return nullptr;
    if (!is_converted)
        convert(*current);
    const bool is_colour = !std::strcmp(channel, "channel.color");
    const bool is_depth = !std::strcmp(channel, "channel.depth");
    if ((is_colour && colours.empty()) || (is_depth && depths.empty()) || (!is_colour && !is_depth))
        return nullptr;
    *width = current->scene.width;
    *height = current->scene.height;
    *type = is_colour ? colour_type : depth_type;
    return is_colour ? static_cast<const void *>(colours.data()) : depths.data();
}

int frame::get_property(const char *name, ANARIDataType type, void *memory, uint64_t size)
{
    if (type != ANARI_FLOAT32 || size < sizeof(float) || !current)
        return 0;
    const bool is_done = is_ready(false);
    float value;
    if (!std::strcmp(name, "duration") && is_done)
        value = current->seconds;
    else if (!std::strcmp(name, "renderProgress") || !std::strcmp(name, "refinementProgress"))
        value = is_done ? 1 : current->share.load();
    else
        return 0;
    std::memcpy(memory, &value, sizeof value);
    return 1;
}

} // namespace cvol_anari
