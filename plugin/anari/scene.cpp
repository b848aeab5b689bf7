#include "scene.h"

#include "host.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cvol_anari
{

/* ---- bounds ---------------------------------------------------------------------------------- */

struct bounds {
    float low[3], high[3];
    bounds()
    {
        std::fill(low, low + 3, std::numeric_limits<float>::infinity());
        std::fill(high, high + 3, -std::numeric_limits<float>::infinity());
    }
    void add(const double at[3])
    {
        for (int a = 0; a < 3; a++) {
            low[a] = std::min(low[a], static_cast<float>(at[a]));
            high[a] = std::max(high[a], static_cast<float>(at[a]));
        }
    }
};

static void add_field(bounds *out, const field &f, const pose &placed)
{
    double centre[3], extent[3];
    f.get_box(centre, extent);
    for (int corner = 0; corner < 8; corner++) {
        double at[3], in_world[3];
        for (int a = 0; a < 3; a++)
            at[a] = centre[a] + (corner >> a & 1 ? 0.5 : -0.5) * extent[a];
        placed.to_world(in_world, at);
        out->add(in_world);
    }
}

static void add_group(bounds *out, const group &g, const pose &placed)
{
    for (const auto &v : g.volumes)
        if (v->is_visible())
            add_field(out, *v->value->drawn, placed);
}

static int give_bounds(const bounds &b, const char *name, ANARIDataType type, void *memory,
                       uint64_t size)
{
    if (std::string(name) != "bounds" || type != ANARI_FLOAT32_BOX3 || size < sizeof b ||
        b.low[0] > b.high[0])
        return 0;
    std::memcpy(memory, &b, sizeof b);
    return 1;
}

/* ---- volumes --------------------------------------------------------------------------------- */

/* Colours are one colour or an array of them. */
static int get_colours(std::vector<double> *out, const volume &v)
{
    double rgba[4] = {0, 0, 0, 1};
    if (const auto *list = static_cast<array *>(v.get_object("color", ANARI_ARRAY1D))) {
        for (uint64_t i = 0; i < list->count(); i++) {
            if (!list->get_colour(rgba, i))
                return 0;
            out->insert(out->end(), rgba, rgba + 4);
        }
        return list->count() > 0;
    }
    const void *three = v.find("color", ANARI_FLOAT32_VEC3);
    const void *four = v.find("color", ANARI_FLOAT32_VEC4);
    if (!three && !four)
        return 0;
    for (int c = 0; c < (four ? 4 : 3); c++)
        rgba[c] = static_cast<const float *>(four ? four : three)[c];
    out->assign(rgba, rgba + 4);
    return 1;
}

static int get_opacities(std::vector<double> *out, const volume &v)
{
    if (const auto *list = static_cast<array *>(v.get_object("opacity", ANARI_ARRAY1D))) {
        if (list->element != ANARI_FLOAT32)
            return 0;
        const auto *values = static_cast<const float *>(list->data());
        out->assign(values, values + list->count());
        return list->count() > 0;
    }
    out->assign(1, static_cast<double>(v.get("opacity", ANARI_FLOAT32, 1.0f)));
    return 1;
}

static void get_range(double out[2], const volume &v)
{
    const void *floats = v.find("valueRange", ANARI_FLOAT32_BOX1);
#ifdef ANARI_FLOAT64_BOX1 /* newer SDKs */
    const void *doubles = v.find("valueRange", ANARI_FLOAT64_BOX1);
#else
    const void *doubles = nullptr;
#endif
    for (int i = 0; i < 2; i++)
        out[i] = doubles  ? static_cast<const double *>(doubles)[i]
                 : floats ? static_cast<double>(static_cast<const float *>(floats)[i])
                          : i;
}

void volume::commit()
{
    visible = get("visible", ANARI_BOOL, int32_t{1}) != 0;
    value = static_cast<spatial_field *>(get_object("value", ANARI_SPATIAL_FIELD));
    auto made = std::make_shared<transfer_function>();
    get_range(made->range, *this);
    made->unit_distance = static_cast<double>(get("unitDistance", ANARI_FLOAT32, 1.0f));
    colours = nullptr;
    const char *wrong = !get_colours(&made->rgba, *this)
                            ? "color must be a colour or an array of colours"
                        : !get_opacities(&made->opacity, *this)
                            ? "opacity must be a number or an array of FLOAT32"
                        : !(made->unit_distance > 0) ? "unitDistance must be above 0"
                        : !std::isfinite(made->range[0]) || !std::isfinite(made->range[1])
                            ? "valueRange must be two finite numbers"
                            : nullptr;
    if (wrong)
        report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT, wrong);
    else
        colours = made;
}

int volume::get_property(const char *name, ANARIDataType type, void *memory, uint64_t size)
{
    bounds b;
    if (is_visible())
        add_field(&b, *value->drawn, pose());
    return give_bounds(b, name, type, memory, size);
}

/* ---- lights, groups, instances --------------------------------------------------------------- */

void light::commit()
{
    shines = subtype == "directional" && get("irradiance", ANARI_FLOAT32, 1.0f) > 0;
    const void *given = find("direction", ANARI_FLOAT32_VEC3);
    for (int a = 0; a < 3; a++)
        direction[a] = given ? static_cast<const float *>(given)[a] : (a == 2 ? -1 : 0);
    if (direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2] > 0)
        return;
    report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT, "direction must not be 0 0 0");
    shines = false;
}

/* The objects of an array parameter, all of one type. */
template <typename T>
static void get_objects(std::vector<reference<T>> *out, object &from, const char *name,
                        ANARIDataType type)
{
    out->clear();
    const auto *list = static_cast<array *>(from.get_object(name, ANARI_ARRAY1D));
    if (!list)
        return;
    for (object *o : list->objects()) {
        if (o->type == type)
            out->emplace_back(static_cast<T *>(o));
        else
            from.report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT,
                        std::string(name) + " has an object that is a " + o->describe());
    }
}

void group::commit()
{
    get_objects(&volumes, *this, "volume", ANARI_VOLUME);
    get_objects(&lights, *this, "light", ANARI_LIGHT);
    const auto *surfaces = static_cast<array *>(get_object("surface", ANARI_ARRAY1D));
    if (surfaces && surfaces->count() > 0)
        report(ANARI_SEVERITY_WARNING, ANARI_STATUS_INVALID_OPERATION,
               "surface: cvol draws volumes only, and leaves surfaces out");
}

int group::get_property(const char *name, ANARIDataType type, void *memory, uint64_t size)
{
    bounds b;
    add_group(&b, *this, pose());
    return give_bounds(b, name, type, memory, size);
}

void instance::commit()
{
    content = static_cast<group *>(get_object("group", ANARI_GROUP));
    placed = pose();
    is_drawable = true;
    const void *matrix = find("transform", ANARI_FLOAT32_MAT4);
    if (!matrix || placed.set(static_cast<const float *>(matrix)))
        return;
    is_drawable = false;
    report(
        ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT,
        "transform must be a rotation, a move, and one scale for all axes; what it places is not "
        "drawn");
}

int instance::get_property(const char *name, ANARIDataType type, void *memory, uint64_t size)
{
    bounds b;
    if (content && is_drawable)
        add_group(&b, *content.get(), placed);
    return give_bounds(b, name, type, memory, size);
}

/* ---- worlds ---------------------------------------------------------------------------------- */

void world::commit()
{
    group::commit();
    get_objects(&instances, *this, "instance", ANARI_INSTANCE);
}

int world::get_property(const char *name, ANARIDataType type, void *memory, uint64_t size)
{
    bounds b;
    add_group(&b, *this, pose());
    for (const auto &i : instances)
        if (i->content && i->is_drawable)
            add_group(&b, *i->content.get(), i->placed);
    return give_bounds(b, name, type, memory, size);
}

static void collect_group(drawing *out, const group &g, const pose &placed)
{
    for (const auto &v : g.volumes)
        if (v->is_visible())
            out->volumes.push_back({v->value->drawn, v->colours, placed});
    for (const auto &l : g.lights) {
        if (!l->shines || out->has_light)
            continue;
        out->has_light = true;
        for (int i = 0; i < 3; i++)
            out->light[i] = placed.rotation[i][0] * l->direction[0] +
                            placed.rotation[i][1] * l->direction[1] +
                            placed.rotation[i][2] * l->direction[2];
    }
}

static bool overlap(const drawn_volume &a, const drawn_volume &b)
{
    bounds of_a, of_b;
    add_field(&of_a, *a.source, a.placed);
    add_field(&of_b, *b.source, b.placed);
    bool is_apart = false;
    for (int i = 0; i < 3; i++)
        is_apart |= of_a.high[i] <= of_b.low[i] || of_b.high[i] <= of_a.low[i];
    return !is_apart;
}

int world::collect(drawing &out) const
{
    collect_group(&out, *this, pose());
    for (const auto &i : instances)
        if (i->content && i->is_drawable)
            collect_group(&out, *i->content.get(), i->placed);
    for (size_t i = 0; i < out.volumes.size(); i++)
        for (size_t j = 0; j < i; j++)
            if (overlap(out.volumes[i], out.volumes[j]))
                return 1;
    return 0;
}

} // namespace cvol_anari
