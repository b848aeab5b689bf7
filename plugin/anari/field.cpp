/* Spatial fields: samples become a compressed array, which engine sheet draws. */
#include "host.h"
#include "scene.h"

#include <cmath>
#include <limits>

namespace cvol_anari
{

/* The PSNR of a field that comes as samples, in dB over the range of its values, if the parameter
 * "psnr" does not say another one. The error of a sample is then 0.1 % of the range at the root of
 * the mean square: a step of an 8-bit transfer function is four times as large. */
static const float PSNR = 60;

/* Samples as cvol stores them, and what they mean. */
struct sample_format {
    ANARIDataType element;
    cvol_type type;
    double scale; /* field value / sample */
};

static const sample_format formats[] = {
    {ANARI_UFIXED8, CVOL_UINT8, 1 / 255.0},
    {ANARI_FIXED16, CVOL_INT16, 1 / 32767.0},
    {ANARI_UFIXED16, CVOL_UINT16, 1 / 65535.0},
    {ANARI_FLOAT32, CVOL_FLOAT32, 1},
    {ANARI_FLOAT64, CVOL_FLOAT64, 1},
    {ANARI_UINT8, CVOL_UINT8, 1},
    {ANARI_INT8, CVOL_INT8, 1},
    {ANARI_UINT16, CVOL_UINT16, 1},
    {ANARI_INT16, CVOL_INT16, 1},
    {ANARI_UINT32, CVOL_UINT32, 1},
    {ANARI_INT32, CVOL_INT32, 1},
};

static const sample_format *find_format(ANARIDataType element)
{
    for (const sample_format &f : formats)
        if (f.element == element)
            return &f;
    return nullptr;
}

/* ---- numbers that are integers --------------------------------------------------------------- */

/* Applications convert scans to floats. If all numbers are integers of a small type, samples of
 * this type are compressed instead. */
struct narrow_samples {
    cvol_type type;
    std::vector<unsigned char> bytes;
};

template <typename T> void convert(std::vector<unsigned char> *out, const float *from, size_t count)
{
    out->resize(count * sizeof(T));
    T *to = reinterpret_cast<T *>(out->data());
    for (size_t i = 0; i < count; i++)
        to[i] = static_cast<T>(from[i]);
}

static bool narrow(narrow_samples *out, const float *from, size_t count)
{
    float least = 0, largest = 0;
    for (size_t i = 0; i < count; i++) {
        if (!(std::fabs(from[i]) <= 65535) || from[i] != std::floor(from[i]))
            return false;
        least = std::min(least, from[i]);
        largest = std::max(largest, from[i]);
    }
    if (least >= 0 && largest <= 255) {
        out->type = CVOL_UINT8;
        convert<uint8_t>(&out->bytes, from, count);
    } else if (least >= 0) {
        out->type = CVOL_UINT16;
        convert<uint16_t>(&out->bytes, from, count);
    } else if (least >= -32768 && largest <= 32767) {
        out->type = CVOL_INT16;
        convert<int16_t>(&out->bytes, from, count);
    } else
        return false;
    return true;
}

/* ---- compression ----------------------------------------------------------------------------- */

template <typename T> bool has_missing(const void *samples, size_t count)
{
    const T *s = static_cast<const T *>(samples);
    for (size_t i = 0; i < count; i++)
        if (!std::isfinite(s[i]))
            return true;
    return false;
}

static int compress(cvol_context *context, cvol_array **out, const void *samples,
                    const cvol_grid &grid, double psnr)
{
    const size_t count = cvol_grid_samples(&grid);
    cvol_compress_options options = cvol_compress_options_defaults();
    options.target = CVOL_TARGET_PSNR;
    options.target_value = psnr;
    options.effort = CVOL_EFFORT_FAST;
    options.background = CVOL_BACKGROUND_FIND;
    if ((grid.type == CVOL_FLOAT32 && has_missing<float>(samples, count)) ||
        (grid.type == CVOL_FLOAT64 && has_missing<double>(samples, count))) {
        options.has_fill = 1;
        options.fill = std::numeric_limits<double>::quiet_NaN();
    }
    return cvol_compress(context, out, nullptr, samples, &grid, &options);
}

/* Finishes a field whose array is made. */
static int prepare(cvol_context *context, field *f)
{
    cvol_source source = {};
    source.size = sizeof source;
    source.array = f->array;
    return cvol_renderer_create(context, &f->renderer, CVOL_ENGINE_SHEET, &source);
}

std::shared_ptr<field> spatial_field::make_from_array()
{
    auto *data = static_cast<array *>(get_object("data", ANARI_ARRAY3D));
    if (!data) {
        report(ANARI_SEVERITY_WARNING, ANARI_STATUS_INVALID_ARGUMENT,
               "data is missing: an ANARI_ARRAY3D of samples");
        return nullptr;
    }
    const sample_format *format = find_format(data->element);
    if (!format) {
        report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT,
               "data has elements of type " + std::to_string(static_cast<int>(data->element)) +
                   ": must be UFIXED8, FIXED16, UFIXED16, FLOAT32, FLOAT64 or integers of up to 32 "
                   "bits");
        return nullptr;
    }
    auto out = std::make_shared<field>();
    float origin[3], spacing[3];
    cvol_grid grid = cvol_grid_make(data->items[0], data->items[1], data->items[2], format->type);
    const void *origin_bytes = find("origin", ANARI_FLOAT32_VEC3);
    const void *spacing_bytes = find("spacing", ANARI_FLOAT32_VEC3);
    for (int a = 0; a < 3; a++) {
        origin[a] = origin_bytes ? static_cast<const float *>(origin_bytes)[a] : 0;
        spacing[a] = spacing_bytes ? static_cast<const float *>(spacing_bytes)[a] : 1;
        out->dims[a] = data->items[a];
        out->origin[a] = origin[a];
        grid.spacing[a] = out->spacing[a] = spacing[a];
    }
    out->scale = format->scale;
    const void *samples = data->data();
    narrow_samples integers;
    if (data->element == ANARI_FLOAT32 &&
        narrow(&integers, static_cast<const float *>(samples), data->count())) {
        grid.type = integers.type;
        samples = integers.bytes.data();
    }
    cvol_context *context = owner.context();
    const double psnr = static_cast<double>(get("psnr", ANARI_FLOAT32, PSNR));
    if (cvol_grid_check(context, &grid, "data") ||
        compress(context, &out->array, samples, grid, psnr) || prepare(context, out.get())) {
        report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT, cvol_context_message(context));
        return nullptr;
    }
    return out;
}

std::shared_ptr<field> spatial_field::make_from_file()
{
    const std::string path = get_text("file", "");
    cvol_context *context = owner.context();
    auto out = std::make_shared<field>();
    if (path.empty()) {
        report(ANARI_SEVERITY_WARNING, ANARI_STATUS_INVALID_ARGUMENT,
               "file is missing: the name of a .cvol file");
        return nullptr;
    }
    if (cvol_array_read(context, &out->array, path.c_str(), nullptr) ||
        prepare(context, out.get())) {
        report(ANARI_SEVERITY_ERROR, ANARI_STATUS_INVALID_ARGUMENT, cvol_context_message(context));
        return nullptr;
    }
    const cvol_grid &grid = *cvol_array_grid(out->array);
    for (int a = 0; a < 3; a++) {
        out->dims[a] = grid.dims[a];
        out->origin[a] = grid.origin[a];
        out->spacing[a] = grid.spacing[a];
    }
    out->scale = grid.value_scale;
    out->offset = grid.value_offset;
    return out;
}

void spatial_field::commit()
{
    drawn = subtype == "cvol" ? make_from_file() : make_from_array();
    const std::string filter = get_text("filter", "linear");
    if (drawn)
        drawn->is_cubic = filter == "cubic";
    if (filter != "linear" && filter != "cubic")
        report(ANARI_SEVERITY_WARNING, ANARI_STATUS_INVALID_ARGUMENT,
               "filter '" + filter + "' is drawn as linear: must be linear or cubic");
}

} // namespace cvol_anari
