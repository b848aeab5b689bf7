/* Axes of an annotation: arrows from one place; those that point away first and fainter. */
#include <math.h>
#include <string.h>

#include "render/view/annotate.h"

typedef struct arrow {
    const char *name;
    float rgb[3];
    double across, down, near; /* of a unit vector, in the picture and towards the eye */
} arrow;

/* Along the samples' axes: x, y, z, or the axes of the patient. */
static void direction_of(double out[3], const cvol_grid *grid, int axis)
{
    for (int a = 0; a < 3; a++)
        out[a] = grid->space == CVOL_SPACE_UNKNOWN ? a == axis : grid->direction[a][axis];
}

static const char *name_of(const cvol_grid *grid, int axis)
{
    static const char *const names[3][3] = {[CVOL_SPACE_UNKNOWN] = {"x", "y", "z"},
                                            [CVOL_SPACE_LPS] = {"L", "P", "S"},
                                            [CVOL_SPACE_RAS] = {"R", "A", "S"}};
    return names[grid->space][axis];
}

static double along(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static arrow arrow_of(const cvol_sketch *s, int axis)
{
    static const float dark[3][3] = {{1, 0.35f, 0.3f}, {0.45f, 0.9f, 0.35f}, {0.45f, 0.65f, 1}};
    static const float bright[3][3] = {
        {0.75f, 0.08f, 0.05f}, {0.05f, 0.5f, 0.05f}, {0.1f, 0.2f, 0.8f}};
    double d[3];
    direction_of(d, s->of->grid, axis);
    arrow a = {.name = name_of(s->of->grid, axis),
               .across = along(d, s->view.right) * (s->of->mirrored ? -1 : 1),
               .down = -along(d, s->view.up),
               .near = along(d, s->view.eye)};
    memcpy(a.rgb, s->grey ? s->pen.rgb : s->is_bright ? bright[axis] : dark[axis], sizeof a.rgb);
    return a;
}

static void draw_arrow(const cvol_sketch *s, const arrow *a, double x, double y, double length)
{
    const double reach = hypot(a->across, a->down), shown = fmax(reach, 1e-9);
    const double ux = a->across / shown, uy = a->down / shown,
                 head = 0.24 * length * fmin(1, 2 * reach);
    const float x0 = (float)x, y0 = (float)y;
    const float x1 = (float)(x + length * a->across), y1 = (float)(y + length * a->down);
    const cvol_segment lines[3] = {
        {x0, y0, x1, y1},
        {x1, y1, x1 - (float)(head * (ux - 0.5 * uy)), y1 - (float)(head * (uy + 0.5 * ux))},
        {x1, y1, x1 - (float)(head * (ux + 0.5 * uy)), y1 - (float)(head * (uy - 0.5 * ux))}};
    cvol_pen pen = s->pen;
    pen.width *= 1.3f;
    memcpy(pen.rgb, a->rgb, sizeof pen.rgb);
    pen.opacity = a->near < -0.3 ? 0.6f : 1;
    cvol_ink_halo(s->image, lines, 3, &pen);
    cvol_ink_stroke(s->image, lines, 3, &pen);
    /* The letter beyond the tip; for an arrow along the view, next to it. */
    const double beyond = length * reach + 0.95 * s->letter;
    const double tx = reach > 0.05 ? ux : -0.7, ty = reach > 0.05 ? uy : -0.7;
    memcpy(pen.rgb, s->pen.rgb, sizeof pen.rgb);
    cvol_text_draw(s->image, s->font, a->name,
                   x + beyond * tx - cvol_text_width(s->font, a->name) / 2,
                   y + beyond * ty + s->letter / 2, &pen);
}

void cvol_sketch_axes(const cvol_sketch *s)
{
    const double length = 2.6 * s->letter, room = length + 1.6 * s->letter;
    const double x = s->view.width - s->margin - room, y = s->view.height - s->margin - room;
    arrow arrows[3];
    for (int axis = 0; axis < 3; axis++) {
        arrows[axis] = arrow_of(s, axis);
        for (int k = axis; k > 0 && arrows[k].near < arrows[k - 1].near; k--) {
            const arrow kept = arrows[k];
            arrows[k] = arrows[k - 1];
            arrows[k - 1] = kept;
        }
    }
    for (int k = 0; k < 3; k++)
        draw_arrow(s, &arrows[k], x, y, length);
}
