/* The renderer of cvol has a camera for one volume, relative to its box. So each volume is drawn
 * with the camera in its own coordinates, and the pictures are put over each other, the nearest
 * centre first. */
#include "draw.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cvol_anari
{

static const double DEGREES = 57.29577951308232;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static double length(const double v[3])
{
    return std::sqrt(dot(v, v));
}

field::~field()
{
    cvol_renderer_free(renderer);
    cvol_array_free(array);
}

void field::get_box(double centre[3], double extent[3]) const
{
    for (int a = 0; a < 3; a++) {
        extent[a] = static_cast<double>(dims[a] - 1) * spacing[a];
        centre[a] = origin[a] + extent[a] / 2;
    }
}

/* ---- poses ----------------------------------------------------------------------------------- */

void pose::to_world(double out[3], const double at[3]) const
{
    for (int i = 0; i < 3; i++)
        out[i] = scale * dot(rotation[i], at) + move[i];
}

void pose::turn_to_object(double out[3], const double direction[3]) const
{
    for (int i = 0; i < 3; i++)
        out[i] = rotation[0][i] * direction[0] + rotation[1][i] * direction[1] +
                 rotation[2][i] * direction[2];
}

void pose::to_object(double out[3], const double at[3]) const
{
    const double from[3] = {at[0] - move[0], at[1] - move[1], at[2] - move[2]};
    turn_to_object(out, from);
    for (int i = 0; i < 3; i++)
        out[i] /= scale;
}

int pose::set(const float matrix[16])
{
    const double tolerance = 1e-4;
    double m[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            m[i][j] = matrix[4 * j + i];
    const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                               m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    const double size = std::cbrt(determinant);
    if (!(size > 0) || !std::isfinite(size))
        return 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const double column = (m[0][i] * m[0][j] + m[1][i] * m[1][j] + m[2][i] * m[2][j]);
            if (!(std::fabs(column / (size * size) - (i == j ? 1 : 0)) < tolerance))
                return 0;
        }
    scale = size;
    for (int i = 0; i < 3; i++) {
        move[i] = matrix[12 + i];
        for (int j = 0; j < 3; j++)
            rotation[i][j] = m[i][j] / size;
    }
    return 1;
}

/* ---- the picture that is drawn --------------------------------------------------------------- */

/* The part of the camera's picture that is shown may be anywhere, and pixels may be wide or narrow.
 * A renderer of cvol draws square pixels around the axis of the camera: it draws the smallest such
 * picture that has the part, as many rows of the part as the frame has. */
struct canvas {
    int width, height;
    double rows;        /* height of the canvas / height of the camera's picture */
    double left, top;   /* of the part that is shown, in pixels of the canvas */
    double column_step; /* columns of the canvas per column of the frame */
};

/* Returns 0 if it is larger than pictures may be. */
static int make_canvas(canvas *out, const drawing &scene)
{
    const camera_state &c = scene.camera;
    const double across = c.region[2] - c.region[0], down = c.region[3] - c.region[1];
    const double wide = 2 * std::max(std::fabs(c.region[0] - 0.5), std::fabs(c.region[2] - 0.5));
    const double high = 2 * std::max(std::fabs(c.region[1] - 0.5), std::fabs(c.region[3] - 0.5));
    const double row = down / scene.height; /* height of a pixel / height of the camera's picture */
    const double height = std::ceil(high / row - 1e-6);
    const double width = std::ceil(wide * c.aspect / row - 1e-6);
    if (!(height <= CVOL_IMAGE_SIZE_MAX) || !(width <= CVOL_IMAGE_SIZE_MAX))
        return 0;
    out->height = static_cast<int>(height);
    out->width = static_cast<int>(width);
    out->rows = height * row;
    out->left = width / 2 + (c.region[0] - 0.5) * c.aspect / row;
    out->top = height / 2 + (0.5 - c.region[3]) / row;
    out->column_step = across * c.aspect / row / scene.width;
    return 1;
}

/* ---- the camera of a volume ------------------------------------------------------------------ */

/* What a pixel's depth means, from that of cvol: world distance = scale (depth + ahead), along rays
 * in perspective. */
struct depth_scale {
    double scale, ahead;
};

static void set_angles(cvol_camera *camera, const double direction[3], const double up[3])
{
    const double eye[3] = {-direction[0], -direction[1], -direction[2]};
    const double level = std::hypot(eye[0], eye[1]);
    const double azimuth = level > 1e-6 ? std::atan2(eye[0], -eye[1]) : 0;
    const double elevation = std::atan2(eye[2], level);
    const double right[3] = {std::cos(azimuth), std::sin(azimuth), 0};
    const double plain_up[3] = {-std::sin(elevation) * std::sin(azimuth),
                                std::sin(elevation) * std::cos(azimuth), std::cos(elevation)};
    camera->azimuth_deg = azimuth * DEGREES;
    camera->elevation_deg = elevation * DEGREES;
    camera->roll_deg = std::atan2(-dot(up, right), dot(up, plain_up)) * DEGREES;
}

/* Only what is before the camera is seen, also in parallel projection. */
static void cut_behind(cvol_clip *clip, const double at[3], const double ahead[3],
                       const double extent[3])
{
    double reach = 0;
    for (int a = 0; a < 3; a++)
        reach += std::fabs(ahead[a]) * extent[a] / 2;
    const double from = dot(at, ahead);
    if (from <= -reach)
        return;
    clip->planes = 1;
    for (int a = 0; a < 3; a++)
        clip->plane[0][a] = ahead[a];
    clip->plane[0][3] = from;
}

static depth_scale set_camera(cvol_render_options *options, const drawn_volume &v,
                              const drawing &scene, const canvas &on)
{
    const camera_state &c = scene.camera;
    const field &f = *v.source;
    double centre[3], extent[3], position[3], ahead[3], up[3], at[3];
    f.get_box(centre, extent);
    v.placed.to_object(position, c.position);
    v.placed.turn_to_object(ahead, c.direction);
    v.placed.turn_to_object(up, c.up);
    for (int a = 0; a < 3; a++)
        at[a] = position[a] - centre[a];
    cvol_camera *camera = &options->camera;
    const double diagonal = length(extent) > 0 ? length(extent) : f.mean_spacing();
    if (!c.is_parallel) {
        camera->placed = 1;
        camera->fov_deg = 2 * DEGREES * std::atan(on.rows * std::tan(c.fovy / 2));
        for (int a = 0; a < 3; a++) {
            camera->eye[a] = at[a];
            camera->look_at[a] = at[a] + diagonal * ahead[a];
            camera->up[a] = up[a];
        }
        return {v.placed.scale, 0};
    }
    set_angles(camera, ahead, up);
    camera->zoom = diagonal * v.placed.scale / (c.height * on.rows);
    const double along = dot(at, ahead);
    for (int a = 0; a < 3; a++)
        camera->look_at[a] = at[a] - along * ahead[a];
    cut_behind(&options->clip, at, ahead, extent);
    return {v.placed.scale, -along - diagonal / 2};
}

/* ---- colours --------------------------------------------------------------------------------- */

static double interpolate(const double *values, size_t count, size_t stride, double at)
{
    const double place = at * static_cast<double>(count - 1);
    const size_t i = std::min(static_cast<size_t>(place), count > 1 ? count - 2 : 0);
    const double next = count > 1 ? values[(i + 1) * stride] : values[0];
    return values[i * stride] + (place - static_cast<double>(i)) * (next - values[i * stride]);
}

/* The transfer function of cvol: linear between points at all places of colours and opacities, in
 * sample values, with opacities of a mean spacing. */
static int make_transfer(cvol_context *context, cvol_transfer **out, const transfer_function &t,
                         const field &f)
{
    const size_t colours = t.rgba.size() / 4, opacities = t.opacity.size();
    std::vector<double> places = {0, 1};
    const bool is_jump = !(t.range[1] > t.range[0]);
    for (size_t i = 1; i + 1 < colours && !is_jump; i++)
        places.push_back(static_cast<double>(i) / static_cast<double>(colours - 1));
    for (size_t i = 1; i + 1 < opacities && !is_jump; i++)
        places.push_back(static_cast<double>(i) / static_cast<double>(opacities - 1));
    std::sort(places.begin(), places.end());
    places.erase(std::unique(places.begin(), places.end()), places.end());
    const double spacings = f.mean_spacing() / t.unit_distance;
    std::vector<cvol_transfer_point> points;
    for (const double at : places) {
        double rgba[4];
        for (size_t c = 0; c < 4; c++)
            rgba[c] = std::clamp(interpolate(&t.rgba[c], colours, 4, at), 0.0, 1.0);
        const double opacity = std::clamp(rgba[3] * interpolate(t.opacity.data(), opacities, 1, at),
                                          0.0, 1.0);
        const double value = t.range[0] + at * (t.range[1] - t.range[0]);
        points.push_back({(value - f.offset) / f.scale, rgba[0], rgba[1], rgba[2],
                          1 - std::pow(1 - opacity, spacings)});
    }
    return cvol_transfer_create(context, out, points.data(), points.size());
}

/* ---- pictures -------------------------------------------------------------------------------- */

static int draw_volume(cvol_context *context, cvol_image *image, depth_scale *depth,
                       const drawn_volume &v, const drawing &scene, const canvas &on)
{
    cvol_render_options options = cvol_render_options_defaults();
    options.width = on.width;
    options.height = on.height;
    if (v.source->is_cubic)
        options.sheet.footprint = CVOL_SHEET_CATMULL_ROM;
    if (scene.is_lit) {
        cvol_render_options_set_studio(&options);
        if (scene.has_light) {
            const double to_light[3] = {-scene.light[0], -scene.light[1], -scene.light[2]};
            v.placed.turn_to_object(options.shading.light, to_light);
            options.illumination.in_view = 0;
        }
    }
    *depth = set_camera(&options, v, scene, on);
    cvol_transfer *transfer = nullptr;
    int code = make_transfer(context, &transfer, *v.colours, *v.source);
    const std::lock_guard<std::mutex> lock(v.source->busy);
    code = code ? code : cvol_renderer_set_transfer(context, v.source->renderer, transfer);
    code = code ? code : cvol_renderer_render(context, v.source->renderer, image, &options);
    cvol_transfer_free(transfer);
    return code;
}

/* One pixel of the frame, from the two columns of the canvas around it. */
static void add_pixel(float *rgba, float *distance, const cvol_image &image, int row, double column,
                      const depth_scale &d, double longer)
{
    const double at = std::clamp(column, 0.0, image.width - 1.0);
    const int left = static_cast<int>(at), right = std::min(left + 1, image.width - 1);
    const float share = static_cast<float>(at - left);
    const float *a = image.values + 4 * (static_cast<size_t>(row) * image.width + left);
    const float *b = image.values + 4 * (static_cast<size_t>(row) * image.width + right);
    const float rest = 1 - rgba[3];
    for (int c = 0; c < 4; c++)
        rgba[c] += rest * (a[c] + share * (b[c] - a[c]));
    const int nearest = share < 0.5f ? left : right;
    const double depth = image.depth[static_cast<size_t>(row) * image.width + nearest];
    *distance = std::min(*distance, static_cast<float>(d.scale * (depth + d.ahead) * longer));
}

static void add_picture(pixels *out, const cvol_image &image, const depth_scale &d,
                        const drawing &scene, const canvas &on)
{
    const double half = on.rows *
                        std::tan(scene.camera.fovy / 2); /* of the canvas, at distance 1 */
    for (uint32_t y = 0; y < scene.height; y++) {
        const double down = on.top + y + 0.5;
        const int row = std::clamp(static_cast<int>(down), 0, on.height - 1);
        for (uint32_t x = 0; x < scene.width; x++) {
            const double across = on.left + (x + 0.5) * on.column_step;
            const double u = (2 * across - on.width) / on.height * half;
            const double v = (2 * down - on.height) / on.height * half;
            const double longer = scene.camera.is_parallel ? 1 : std::sqrt(1 + u * u + v * v);
            const size_t i = static_cast<size_t>(scene.height - 1 - y) * scene.width + x;
            add_pixel(&out->rgba[4 * i], &out->depth[i], image, row, across - 0.5, d, longer);
        }
    }
}

/* Distance of a volume's centre from the camera, along its direction or, in perspective, the
 * shortest way. */
static double find_distance(const drawn_volume &v, const camera_state &c)
{
    double centre[3], extent[3], at[3];
    v.source->get_box(centre, extent);
    v.placed.to_world(at, centre);
    for (int a = 0; a < 3; a++)
        at[a] -= c.position[a];
    return c.is_parallel ? dot(at, c.direction) : length(at);
}

std::string draw(cvol_context *context, pixels *out, const drawing &scene)
{
    canvas on;
    if (!make_canvas(&on, scene))
        return "size, aspect and imageRegion need a picture of more than " +
               std::to_string(CVOL_IMAGE_SIZE_MAX) + " rows or columns";
    const size_t count = static_cast<size_t>(scene.width) * scene.height;
    out->rgba.assign(4 * count, 0);
    out->depth.assign(count, std::numeric_limits<float>::infinity());
    int code = CVOL_OK;
    std::vector<drawn_volume> volumes = scene.volumes;
    std::stable_sort(volumes.begin(), volumes.end(),
                     [&](const drawn_volume &a, const drawn_volume &b) {
                         return find_distance(a, scene.camera) < find_distance(b, scene.camera);
                     });
    for (const drawn_volume &v : volumes) {
        cvol_image *image = nullptr;
        depth_scale depth = {1, 0};
        code = code ? code : cvol_image_create_float(context, &image, on.width, on.height);
        code = code ? code : cvol_image_add_depth(context, image);
        code = code ? code : draw_volume(context, image, &depth, v, scene, on);
        if (!code)
            add_picture(out, *image, depth, scene, on);
        cvol_image_free(image);
    }
    return code ? cvol_context_message(context) : "";
}

} // namespace cvol_anari
