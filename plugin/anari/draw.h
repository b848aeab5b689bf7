/* Pictures of what a frame shows. Nothing here refers to objects of the application, so a thread
 * can draw while the application changes them. */
#ifndef CVOL_ANARI_DRAW_H
#define CVOL_ANARI_DRAW_H

#include <cvol/cvol.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace cvol_anari
{

/* A compressed volume and its renderer. Field value = scale x sample + offset. */
struct field {
    ~field();
    cvol_array *array = nullptr;
    cvol_renderer *renderer = nullptr;
    std::mutex busy; /* of the renderer */
    double origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1};
    size_t dims[3] = {1, 1, 1};
    double scale = 1, offset = 0;
    bool is_cubic = false; /* filter */

    double mean_spacing() const
    {
        return (spacing[0] + spacing[1] + spacing[2]) / 3;
    }
    /* The middle and the lengths of the box of sample centres. */
    void get_box(double centre[3], double extent[3]) const;
};

/* Colours and opacities at equal distances over a range of field values; outside it those of its
 * ends. An opacity is that of a length of unit_distance. */
struct transfer_function {
    double range[2] = {0, 1};
    std::vector<double> rgba, opacity; /* four numbers a colour; at least one of each */
    double unit_distance = 1;
};

/* A rotation, one scale for all axes, and a move: world = scale rotation object + move. Rows of the
 * rotation are those of its matrix. */
struct pose {
    double rotation[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double scale = 1;
    double move[3] = {0, 0, 0};
    void to_world(double out[3], const double at[3]) const;
    void to_object(double out[3], const double at[3]) const;
    void turn_to_object(double out[3], const double direction[3]) const;
    /* Finds the pose of a matrix, column by column. Returns 0 if it is sheared, mirrored, or scaled
     * differently along its axes. */
    int set(const float matrix[16]);
};

struct drawn_volume {
    std::shared_ptr<field> source;
    std::shared_ptr<const transfer_function> colours;
    pose placed;
};

struct camera_state {
    bool is_parallel = false;
    double position[3] = {0, 0, 0}, direction[3] = {0, 0, -1}, up[3] = {0, 1, 0};
    double fovy = 1.0471975511965976; /* pi / 3 */
    double height = 1;                /* parallel */
    double aspect = 1;
    double region[4] = {0, 0, 1, 1}; /* left, bottom, right, top of what is shown */
};

/* Everything a picture depends on. */
struct drawing {
    std::vector<drawn_volume> volumes;
    camera_state camera;
    uint32_t width = 0, height = 0;
    bool is_lit = false;
    bool has_light = false;
    double light[3] = {0, 0, -1}; /* where it shines */
};

/* Pixels, bottom row first: R, G and B times A, and A; and distances from the eye (in parallel
 * projection from the plane through the camera), infinite where less than half is hidden. */
struct pixels {
    std::vector<float> rgba, depth;
};

/* Draws a picture. Returns what went wrong, or "". */
std::string draw(cvol_context *context, pixels *out, const drawing &scene);

} // namespace cvol_anari
#endif
