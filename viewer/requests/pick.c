/* The sample at a place of a picture. It draws a few pixels with depth, by a camera with the place
 * at its centre; the depth gives the end of the ray.
 *
 * Positions are relative to the centre of the volume's box, in its unit of length. At the distance
 * of look_at, the ray of fraction (x, y) of a picture passes
 *
 *     q = look_at + (x - 1/2) W right + (1/2 - y) H up,   H = diagonal / zoom, W = H width /
 * height.
 */
#include "viewer/requests/pick.h"

#include <math.h>
#include <stdlib.h>

#include "viewer/view/view.h"
#include "viewer/volumes/labels.h"
#include "viewer/volumes/samples.h"
#include "viewer/volumes/volume_renderers.h"

/* Its pixels are smaller by this factor, so that the centre is exact. */
static const double finer = 4;
enum { SIZE_LEAST = 5, SIZE_MOST = 65 };

#define RADIANS_PER_DEGREE 0.017453292519943295

typedef struct pick {
    view view;
    double x, y; /* fractions of width and height, from the top left */
} pick;

/* The ray. */
typedef struct sight {
    double from[3], along[3];    /* depth d is at from + d along */
    double plane[3], towards[3]; /* the picture's depth of p is (p - plane) towards */
} sight;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The axes of a camera: the columns of its rotation. */
static void find_axes(double right[3], double up[3], double eye[3], const cvol_camera *camera)
{
    double q[4];
    cvol_camera_get_rotation(q, camera);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    const double columns[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
        {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
        {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
    for (int a = 0; a < 3; a++) {
        right[a] = columns[0][a];
        up[a] = columns[1][a];
        eye[a] = columns[2][a];
    }
}

/* The diagonal of the box, as cameras use it. */
static double diagonal_of(const cvol_grid *g)
{
    double extent[3], mean = 0;
    for (int a = 0; a < 3; a++) {
        extent[a] = (double)(g->dims[a] - 1) * g->spacing[a];
        mean += g->spacing[a] / 3;
    }
    const double diagonal = hypot(hypot(extent[0], extent[1]), extent[2]);
    return diagonal > 0 ? diagonal : mean;
}

/* Turns the camera of the view to the place, in parallel or from the same eye. */
static sight aim(pick *p)
{
    cvol_render_options *o = &p->view.options;
    cvol_camera *camera = &o->camera;
    const double diagonal = diagonal_of(&p->view.volume->grid);
    const double pixel = diagonal / camera->zoom / o->height;
    const double across = ((p->view.mirror ? 1 - p->x : p->x) - 0.5) * o->width * pixel;
    const double above = (0.5 - p->y) * o->height * pixel;
    double right[3], up[3], eye[3], at[3], length = 0;
    sight s;
    find_axes(right, up, eye, camera);
    const double distance = diagonal / camera->zoom / 2 /
                            tan(camera->fov_deg / 2 * RADIANS_PER_DEGREE);
    for (int a = 0; a < 3; a++) {
        at[a] = camera->look_at[a] + across * right[a] + above * up[a];
        s.towards[a] = -eye[a];
        s.along[a] = -eye[a];
        s.plane[a] = diagonal / 2 * eye[a];
    }
    o->width = o->height = SIZE_LEAST;
    if (camera->fov_deg > 0) {
        for (int a = 0; a < 3; a++) {
            camera->eye[a] = s.from[a] = s.plane[a] = camera->look_at[a] + distance * eye[a];
            s.along[a] = at[a] - s.from[a];
            length = hypot(length, s.along[a]);
        }
        for (int a = 0; a < 3; a++)
            s.along[a] /= length;
        camera->placed = 1;
        camera->fov_deg = 1;
        /* the pixels of this narrow field are small enough */
        const double pixels = finer * 2 * tan(0.5 * RADIANS_PER_DEGREE) * length / pixel;
        o->width = o->height = 1 + 2 * (int)(fmin(fmax(pixels, SIZE_LEAST), SIZE_MOST) / 2);
    } else {
        for (int a = 0; a < 3; a++)
            s.from[a] = at[a] + (diagonal / 2 - dot(at, eye)) * eye[a];
        camera->zoom = diagonal / (pixel / finer * SIZE_LEAST);
    }
    for (int a = 0; a < 3; a++)
        camera->look_at[a] = at[a];
    return s;
}

/* The depth at the centre of the picture; infinity: nothing visible. */
static int measure(cvol_context *context, double *depth, const view *v)
{
    const int size = v->options.width;
    cvol_image *image = NULL;
    idle_renderer *renderer = volume_take_renderer(context, v->volume, view_shows_labels(v));
    int code = renderer ? cvol_image_create(context, &image, size, size) : CVOL_ERROR_MEMORY;
    if (!code)
        code = cvol_image_add_depth(context, image);
    if (!code)
        code = view_set_transfer(context, renderer, v);
    if (!code)
        code = volume_draw(context, v->volume, renderer, image, &v->options);
    if (!code)
        *depth = (double)image->depth[(size_t)(size / 2) * (size_t)size + (size_t)(size / 2)];
    cvol_image_free(image);
    volume_return_renderer(v->volume, renderer);
    if (!code)
        code = overlays_find_depth(context, depth, v->volume, v->overlays, v->overlay_count,
                                   &v->options,
                                   (size_t)(size / 2) * (size_t)size + (size_t)(size / 2));
    return code;
}

/* The label that is seen at the place: the nearest sample may have none. */
static void put_label(json_t *object, const shown_volume *v, const double place[3])
{
    const int label = labels_at(v, place);
    const char *name = labels_name(v, label);
    if (!label)
        return;
    json_object_set_new(object, "value", json_integer(label));
    json_object_set_new(object, "label", answer_text(name));
}

static answer run(job *j, cvol_context *context, void *state)
{
    pick *p = state;
    const cvol_grid grid = p->view.volume->grid, *g = &grid; /* of all times */
    const sight s = aim(p);
    double depth, place[3], behind[3];
    int code = view_open(context, &p->view);
    if (!code)
        code = measure(context, &depth, &p->view);
    if (code)
        return jobs_failed(j, context, code);
    if (!isfinite(depth))
        return answer_json(200, json_pack("{s:b}", "hit", 0));
    for (int a = 0; a < 3; a++) {
        const double last = (double)(g->dims[a] - 1), from_middle = s.from[a] + depth * s.along[a];
        behind[a] = from_middle - s.plane[a];
        place[a] = fmin(fmax(from_middle / g->spacing[a] + last / 2, 0), last);
    }
    json_t *object;
    code = samples_describe(context, &object, p->view.volume, place);
    if (code)
        return jobs_failed(j, context, code);
    if (view_shows_labels(&p->view))
        put_label(object, p->view.volume, place);
    json_object_set_new(object, "overlays",
                        overlays_describe_place(context, p->view.volume, place, 1));
    json_object_set_new(object, "hit", json_true());
    json_object_set_new(object, "depth", json_real(dot(behind, s.towards)));
    json_object_set_new(object, "sample", json_pack("[f, f, f]", place[0], place[1], place[2]));
    return answer_json(200, object);
}

static void free_pick(void *state)
{
    pick *p = state;
    view_free(&p->view);
    free(p);
}

/* 0, or a status of HTTP, with the message in f->error. */
static int take(pick *out, volumes *all, fields *f)
{
    fields inner = take_object(f, "view", "view.");
    if (!inner.object)
        fields_fail(f, "view is missing: give the view of the picture");
    const int status = fields_ok(f) ? view_take(&out->view, all, &inner) : 400;
    fields_end(&inner);
    if (status)
        return status;
    const int there = take_number(f, "x", &out->x, 0, 1) + take_number(f, "y", &out->y, 0, 1);
    if (there < 2)
        fields_fail(f, "give x and y, fractions of width and height from the top left");
    const cvol_mode mode = out->view.options.mode;
    if (mode != CVOL_MODE_COMPOSITE && mode != CVOL_MODE_ISO)
        fields_fail(f, "view.mode must be composite or iso");
    fields_end(f);
    return fields_ok(f) ? 0 : 400;
}

answer pick_post(request *r)
{
    char error[512] = "";
    json_t *body;
    fields_parse(&body, r->body, r->body_bytes, error, sizeof error);
    fields f = {body, NULL, "", error, sizeof error};
    pick *p = body ? calloc(1, sizeof *p) : NULL;
    const int status = p ? take(p, r->service->volumes, &f) : 400;
    json_decref(body);
    if (!status)
        return request_later(r, "", -1, 0, run, p, free_pick);
    if (p)
        free_pick(p);
    return answer_error(status, "%s", error[0] ? error : "not enough memory for a request");
}
