/* The device of ANARI, by a client that sees only the API: pictures against a ray caster of its own
 * on the original samples, in double precision; messages; memory of the application.
 * usage: anari_client FILE.cvol SAMPLES.raw NX NY NZ [PICTURE.ppm]     a volume of uint8
 * ANARI_LIBRARY names the library, and LD_LIBRARY_PATH has its folder. */
#define _GNU_SOURCE
#include <anari/anari.h>

#include <dlfcn.h>
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

static int failures;

#define EXPECT(condition)                                                \
    do {                                                                 \
        if (!(condition)) {                                              \
            printf("anari_client: line %d: %s\n", __LINE__, #condition); \
            failures++;                                                  \
        }                                                                \
    } while (0)

/* ---- messages -------------------------------------------------------------------------------- */

static char last_message[512];
static int messages;

static void receive(const void *user, ANARIDevice device, ANARIObject source, ANARIDataType type,
                    ANARIStatusSeverity severity, ANARIStatusCode code, const char *message)
{
    (void)user, (void)device, (void)source, (void)type, (void)code;
    if (severity > ANARI_SEVERITY_WARNING)
        return;
    snprintf(last_message, sizeof last_message, "%s", message);
    messages++;
}

/* The last message has this text, and was the only one. */
static int was_told(const char *text)
{
    const int right = messages == 1 && strstr(last_message, text);
    if (!right)
        printf("anari_client: %d messages, the last is '%s'; expected '%s'\n", messages,
               last_message, text);
    messages = 0;
    return right;
}

/* ---- a scene --------------------------------------------------------------------------------- */

/* Samples are those of a field of uint8 (values 0 to 255, or 0 to 1 as UFIXED8) or floats. */
typedef struct volume_of_test {
    int dims[3];
    float origin[3], spacing[3];
    float *samples;
    float matrix[16]; /* column by column */
    int has_matrix;
} volume_of_test;

enum { COLOURS = 3, OPACITIES = 5 };
static const float colours[COLOURS][3] = {{0.1f, 0.2f, 0.9f}, {0.9f, 0.4f, 0.1f}, {1, 1, 0.8f}};
static const float opacities[OPACITIES] = {0, 0.02f, 0.05f, 0.3f, 0.6f};

typedef struct view_of_test {
    int is_parallel, width, height;
    float position[3], direction[3], up[3], fovy, tall, aspect, region[4];
} view_of_test;

static float range[2] = {0, 1}, unit_distance = 1;

static float blob(const float at[3], float x, float y, float z, float size)
{
    const float d = (at[0] - x) * (at[0] - x) + (at[1] - y) * (at[1] - y) +
                    (at[2] - z) * (at[2] - z);
    return expf(-d / (2 * size * size));
}

static volume_of_test make_volume(void)
{
    volume_of_test v = {{44, 36, 30}, {-3, 2, 5}, {1, 1.25f, 1.5f}, NULL, {0}, 0};
    v.samples = malloc(sizeof *v.samples * 44 * 36 * 30);
    for (int z = 0; z < 30; z++)
        for (int y = 0; y < 36; y++)
            for (int x = 0; x < 44; x++) {
                const float at[3] = {(float)x / 43, (float)y / 35, (float)z / 29};
                v.samples[x + 44 * (y + 36 * z)] = blob(at, 0.3f, 0.35f, 0.4f, 0.12f) +
                                                   0.7f * blob(at, 0.7f, 0.6f, 0.3f, 0.1f) +
                                                   0.5f * blob(at, 0.55f, 0.75f, 0.8f, 0.09f);
            }
    return v;
}

/* ---- the oracle ------------------------------------------------------------------------------ */

static double sample_at(const volume_of_test *v, const double p[3], int *inside)
{
    size_t i[3];
    double f[3], sum = 0;
    *inside = 0;
    for (int a = 0; a < 3; a++) {
        const double at = (p[a] - v->origin[a]) / v->spacing[a];
        if (!(at >= 0 && at <= v->dims[a] - 1))
            return 0;
        i[a] = (size_t)at < (size_t)v->dims[a] - 1 ? (size_t)at : (size_t)v->dims[a] - 2;
        f[a] = at - (double)i[a];
    }
    for (size_t c = 0; c < 8; c++)
        sum += (c & 1 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 4 ? f[2] : 1 - f[2]) *
               v->samples[i[0] + (c & 1) +
                          (size_t)v->dims[0] *
                              (i[1] + (c >> 1 & 1) + (size_t)v->dims[1] * (i[2] + (c >> 2)))];
    *inside = 1;
    return sum;
}

static double between(const float *values, int count, int stride, double at)
{
    const double place = at * (count - 1);
    const int i = place < count - 2 ? (int)place : count - 2;
    return values[i * stride] + (place - i) * (values[(i + 1) * stride] - values[i * stride]);
}

/* World to object: matrix = scale rotation | move. */
static void to_object(const volume_of_test *v, double out[3], const double in[3], int is_direction)
{
    if (!v->has_matrix) {
        memcpy(out, in, 3 * sizeof *out);
        return;
    }
    const float *m = v->matrix;
    const double square = m[0] * m[0] + m[1] * m[1] + m[2] * m[2];
    for (int i = 0; i < 3; i++) {
        out[i] = 0;
        for (int j = 0; j < 3; j++)
            out[i] += m[4 * i + j] * (in[j] - (is_direction ? 0 : m[12 + j])) / square;
    }
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double norm(const double v[3])
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* The ray of a place of the picture, 0 to 1 from the left and from below. */
static void make_ray(const view_of_test *c, double s, double t, double from[3], double along[3])
{
    double ahead[3], up[3], right[3];
    for (int a = 0; a < 3; a++) {
        ahead[a] = c->direction[a];
        up[a] = c->up[a];
    }
    const double length = norm(ahead);
    for (int a = 0; a < 3; a++)
        ahead[a] /= length;
    cross(right, ahead, up);
    const double wide = norm(right);
    for (int a = 0; a < 3; a++)
        right[a] /= wide;
    cross(up, right, ahead);
    const double tall = c->is_parallel ? c->tall : 2 * tan(c->fovy / 2);
    const double x = (s - 0.5) * tall * c->aspect, y = (t - 0.5) * tall;
    for (int a = 0; a < 3; a++) {
        const double beside = x * right[a] + y * up[a];
        from[a] = c->position[a] + (c->is_parallel ? beside : 0);
        along[a] = ahead[a] + (c->is_parallel ? 0 : beside);
    }
    const double l = norm(along);
    for (int a = 0; a < 3; a++)
        along[a] /= l;
}

/* Colour times opacity, opacity, and the distance at which opacity reaches one half. */
static void cast(const volume_of_test *v, const view_of_test *c, double s, double t, double out[5])
{
    double from[3], along[3], p[3], d[3];
    make_ray(c, s, t, from, along);
    to_object(v, p, from, 0);
    to_object(v, d, along, 1); /* object length of a world length */
    const double step = 0.1;
    out[0] = out[1] = out[2] = out[3] = 0;
    out[4] = INFINITY;
    for (double at = step / 2; at < 400; at += step) {
        const double q[3] = {p[0] + at * d[0], p[1] + at * d[1], p[2] + at * d[2]};
        int inside;
        const double value = sample_at(v, q, &inside);
        if (!inside)
            continue;
        double place = (value - range[0]) / (range[1] - range[0]);
        place = place < 0 ? 0 : place > 1 ? 1 : place;
        const double opacity = between(opacities, OPACITIES, 1, place);
        const double a = (1 - out[3]) * (1 - pow(1 - opacity, step * norm(d) / unit_distance));
        for (int i = 0; i < 3; i++)
            out[i] += a * between(&colours[0][i], COLOURS, 3, place);
        if (out[3] < 0.5 && out[3] + a >= 0.5)
            out[4] = at;
        out[3] += a;
    }
}

/* ---- objects --------------------------------------------------------------------------------- */

static void set_and_release(ANARIDevice d, ANARIObject o, const char *name, ANARIDataType type,
                            ANARIObject value)
{
    anariSetParameter(d, o, name, type, &value);
    anariRelease(d, value);
}

static ANARISpatialField make_field(ANARIDevice d, const volume_of_test *v, ANARIDataType type)
{
    ANARISpatialField field = anariNewSpatialField(d, "structuredRegular");
    uint64_t stride;
    const size_t count = (size_t)v->dims[0] * (size_t)v->dims[1] * (size_t)v->dims[2];
    void *data = anariMapParameterArray3D(d, field, "data", type, (uint64_t)v->dims[0],
                                          (uint64_t)v->dims[1], (uint64_t)v->dims[2], &stride);
    if (type == ANARI_FLOAT32)
        memcpy(data, v->samples, count * sizeof(float));
    for (size_t i = 0; type == ANARI_UFIXED8 && i < count; i++)
        ((uint8_t *)data)[i] = (uint8_t)lrintf(255 * v->samples[i]);
    anariUnmapParameterArray(d, field, "data");
    anariSetParameter(d, field, "origin", ANARI_FLOAT32_VEC3, v->origin);
    anariSetParameter(d, field, "spacing", ANARI_FLOAT32_VEC3, v->spacing);
    anariCommitParameters(d, field);
    return field;
}

static ANARIVolume make_anari_volume(ANARIDevice d, ANARISpatialField field)
{
    ANARIVolume volume = anariNewVolume(d, "transferFunction1D");
    anariSetParameter(d, volume, "value", ANARI_SPATIAL_FIELD, &field);
    anariSetParameter(d, volume, "valueRange", ANARI_FLOAT32_BOX1, range);
    anariSetParameter(d, volume, "unitDistance", ANARI_FLOAT32, &unit_distance);
    set_and_release(d, volume, "color", ANARI_ARRAY1D,
                    anariNewArray1D(d, colours, NULL, NULL, ANARI_FLOAT32_VEC3, COLOURS));
    set_and_release(d, volume, "opacity", ANARI_ARRAY1D,
                    anariNewArray1D(d, opacities, NULL, NULL, ANARI_FLOAT32, OPACITIES));
    anariCommitParameters(d, volume);
    return volume;
}

static ANARIWorld make_world(ANARIDevice d, ANARIVolume volume, const float *matrix)
{
    ANARIWorld world = anariNewWorld(d);
    ANARIArray1D volumes = anariNewArray1D(d, &volume, NULL, NULL, ANARI_VOLUME, 1);
    if (!matrix)
        set_and_release(d, world, "volume", ANARI_ARRAY1D, volumes);
    else {
        ANARIGroup group = anariNewGroup(d);
        set_and_release(d, group, "volume", ANARI_ARRAY1D, volumes);
        anariCommitParameters(d, group);
        ANARIInstance instance = anariNewInstance(d, "transform");
        set_and_release(d, instance, "group", ANARI_GROUP, group);
        anariSetParameter(d, instance, "transform", ANARI_FLOAT32_MAT4, matrix);
        anariCommitParameters(d, instance);
        ANARIArray1D instances = anariNewArray1D(d, &instance, NULL, NULL, ANARI_INSTANCE, 1);
        anariRelease(d, instance);
        set_and_release(d, world, "instance", ANARI_ARRAY1D, instances);
    }
    anariCommitParameters(d, world);
    return world;
}

static ANARICamera make_camera(ANARIDevice d, const view_of_test *c)
{
    ANARICamera camera = anariNewCamera(d, c->is_parallel ? "orthographic" : "perspective");
    anariSetParameter(d, camera, "position", ANARI_FLOAT32_VEC3, c->position);
    anariSetParameter(d, camera, "direction", ANARI_FLOAT32_VEC3, c->direction);
    anariSetParameter(d, camera, "up", ANARI_FLOAT32_VEC3, c->up);
    anariSetParameter(d, camera, "aspect", ANARI_FLOAT32, &c->aspect);
    anariSetParameter(d, camera, "imageRegion", ANARI_FLOAT32_BOX2, c->region);
    if (c->is_parallel)
        anariSetParameter(d, camera, "height", ANARI_FLOAT32, &c->tall);
    else
        anariSetParameter(d, camera, "fovy", ANARI_FLOAT32, &c->fovy);
    anariCommitParameters(d, camera);
    return camera;
}

static ANARIFrame make_frame(ANARIDevice d, ANARIWorld world, const view_of_test *c,
                             const char *subtype, ANARIDataType colour_type)
{
    static const float clear[4] = {0, 0, 0, 0};
    const ANARIDataType depth_type = ANARI_FLOAT32;
    const uint32_t size[2] = {(uint32_t)c->width, (uint32_t)c->height};
    ANARIRenderer renderer = anariNewRenderer(d, subtype);
    anariSetParameter(d, renderer, "background", ANARI_FLOAT32_VEC4, clear);
    anariCommitParameters(d, renderer);
    ANARIFrame frame = anariNewFrame(d);
    anariSetParameter(d, frame, "world", ANARI_WORLD, &world);
    set_and_release(d, frame, "renderer", ANARI_RENDERER, renderer);
    set_and_release(d, frame, "camera", ANARI_CAMERA, make_camera(d, c));
    anariSetParameter(d, frame, "size", ANARI_UINT32_VEC2, size);
    anariSetParameter(d, frame, "channel.color", ANARI_DATA_TYPE, &colour_type);
    anariSetParameter(d, frame, "channel.depth", ANARI_DATA_TYPE, &depth_type);
    anariCommitParameters(d, frame);
    return frame;
}

static const void *draw(ANARIDevice d, ANARIFrame frame, const char *channel, uint32_t size[2])
{
    ANARIDataType type;
    anariRenderFrame(d, frame);
    anariFrameReady(d, frame, ANARI_WAIT);
    return anariMapFrame(d, frame, channel, &size[0], &size[1], &type);
}

/* ---- pictures -------------------------------------------------------------------------------- */

/* Bounds of the difference of a picture from the oracle: that of interpolation between slices, and
 * of compression at 60 dB. Depths are compared where the opacity rises well above one half:
 * elsewhere a small difference of opacity is a large one of depth. */
static void check_picture(const char *name, ANARIDevice d, const volume_of_test *v,
                          const view_of_test *c, ANARIDataType type)
{
    ANARISpatialField field = make_field(d, v, type);
    ANARIVolume volume = make_anari_volume(d, field);
    ANARIWorld world = make_world(d, volume, v->has_matrix ? v->matrix : NULL);
    ANARIFrame frame = make_frame(d, world, c, "default", ANARI_FLOAT32_VEC4);
    uint32_t size[2] = {0, 0};
    ANARIDataType depth_type;
    const float *colour = draw(d, frame, "channel.color", size);
    const float *depth = anariMapFrame(d, frame, "channel.depth", &size[0], &size[1], &depth_type);
    double sum = 0, most = 0, depth_sum = 0, depths = 0, jumps = 0, seen = 0;
    EXPECT(colour && depth && (int)size[0] == c->width && (int)size[1] == c->height);
    for (int y = 0; colour && depth && y < c->height; y++)
        for (int x = 0; x < c->width; x++) {
            const size_t i = (size_t)x + (size_t)c->width * (size_t)y;
            const double s = c->region[0] + (c->region[2] - c->region[0]) * (x + 0.5) / c->width;
            const double t = c->region[1] + (c->region[3] - c->region[1]) * (y + 0.5) / c->height;
            double right[5];
            cast(v, c, s, t, right);
            const float *p = colour + 4 * i;
            for (int k = 0; k < 4; k++) {
                const double e = fabs((k < 3 ? p[k] * p[3] : p[3]) - right[k]);
                sum += e;
                most = e > most ? e : most;
            }
            seen += right[3];
            if (right[3] > 0.75) {
                const double e = fabs(depth[i] - right[4]);
                jumps += !(e < 1);
                depth_sum += e < 1 ? e : 0;
                depths++;
            }
        }
    const double mean = sum / 4 / c->width / c->height;
    printf("%-28s difference: mean %.5f, largest %.4f; of depth: mean %.3f, %g jumps of %g\n", name,
           mean, most, depth_sum / depths, jumps, depths);
    EXPECT(mean < 0.002);
    EXPECT(most < 0.03);
    EXPECT(depths > 5 && depth_sum < 0.2 * depths && jumps <= 0.02 * depths);
    EXPECT(seen > 0.02 * c->width * c->height);
    anariRelease(d, frame);
    anariRelease(d, world);
    anariRelease(d, volume);
    anariRelease(d, field);
}

static void turn(float matrix[16], const double axis_in[3], double angle, double scale,
                 const double move[3])
{
    double n[3] = {axis_in[0], axis_in[1], axis_in[2]};
    const double l = norm(n), c = cos(angle), s = sin(angle);
    for (int i = 0; i < 3; i++)
        n[i] /= l;
    const double skew[3][3] = {{0, -n[2], n[1]}, {n[2], 0, -n[0]}, {-n[1], n[0], 0}};
    memset(matrix, 0, 16 * sizeof *matrix);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            matrix[4 * j + i] = (float)(scale * ((i == j ? c : 0) + (1 - c) * n[i] * n[j] +
                                                 s * skew[i][j]));
        matrix[12 + i] = (float)move[i];
    }
    matrix[15] = 1;
}

static void check_pictures(ANARIDevice d)
{
    volume_of_test v = make_volume();
    const view_of_test plain = {0,    60, 60, {20, -45, 40}, {-0.1f, 1, -0.3f}, {0, 0, 1},
                                0.9f, 0,  1,  {0, 0, 1, 1}};
    view_of_test c = plain;
    check_picture("perspective", d, &v, &c, ANARI_FLOAT32);
    check_picture("perspective, UFIXED8", d, &v, &c, ANARI_UFIXED8);
    c = plain;
    c.width = 90;
    c.height = 50;
    c.aspect = 1.8f;
    c.up[0] = 0.4f; /* turned */
    check_picture("wide, turned", d, &v, &c, ANARI_FLOAT32);
    c = plain;
    c.region[0] = 0.25f, c.region[1] = 0.4f, c.region[2] = 0.75f, c.region[3] = 0.9f;
    check_picture("a part of the picture", d, &v, &c, ANARI_FLOAT32);
    c = plain;
    c.aspect = 1.5f; /* pixels wider than tall */
    check_picture("wide pixels", d, &v, &c, ANARI_FLOAT32);
    c = plain;
    c.is_parallel = 1;
    c.tall = 60;
    check_picture("parallel", d, &v, &c, ANARI_FLOAT32);
    c.position[0] = 18, c.position[1] = 20, c.position[2] = 27; /* in the volume */
    check_picture("parallel, within", d, &v, &c, ANARI_FLOAT32);
    c = plain;
    c.is_parallel = 1;
    c.tall = 60;
    c.position[0] = 18, c.position[1] = 22, c.position[2] = 120;
    c.direction[0] = c.direction[1] = 0, c.direction[2] = -1;
    c.up[1] = 1, c.up[2] = 0;
    check_picture("parallel, from the top", d, &v, &c, ANARI_FLOAT32);
    unit_distance = 2.5f;
    range[0] = 0.1f, range[1] = 0.8f;
    check_picture("unit distance and range", d, &v, &plain, ANARI_FLOAT32);
    unit_distance = 1;
    range[0] = 0, range[1] = 1;
    v.has_matrix = 1;
    turn(v.matrix, (double[3]){0.2, 0.5, 1}, 0.8, 0.7, (double[3]){10, -6, 8});
    check_picture("a turned, small instance", d, &v, &plain, ANARI_FLOAT32);
    free(v.samples);
}

/* ---- everything else ------------------------------------------------------------------------- */

static int deleted;

static void delete_samples(const void *user, const void *memory)
{
    (void)memory;
    EXPECT(user == &deleted);
    deleted++;
}

/* The application gives its array away while a field holds it; the device copies what it needs. */
static void check_memory(ANARIDevice d)
{
    static float samples[8 * 8 * 8];
    ANARISpatialField field = anariNewSpatialField(d, "structuredRegular");
    ANARIArray3D data = anariNewArray3D(d, samples, delete_samples, &deleted, ANARI_FLOAT32, 8, 8,
                                        8);
    anariSetParameter(d, field, "data", ANARI_ARRAY3D, &data);
    EXPECT(deleted == 0);
    anariRelease(d, data);
    EXPECT(deleted == 1);
    anariCommitParameters(d, field);
    anariRelease(d, field);
    EXPECT(deleted == 1);
    data = anariNewArray3D(d, samples, delete_samples, &deleted, ANARI_FLOAT32, 8, 8, 8);
    anariRetain(d, data);
    anariRelease(d, data);
    EXPECT(deleted == 1);
    anariRelease(d, data);
    EXPECT(deleted == 2);
    EXPECT(messages == 0);
}

static void check_messages(ANARIDevice d)
{
    volume_of_test v = make_volume();
    const view_of_test c = {0, 8, 8, {20, -45, 40}, {0, 1, 0}, {0, 0, 1}, 0.9f, 0, 1, {0, 0, 1, 1}};
    ANARISpatialField field = anariNewSpatialField(d, "structuredRegular");
    anariCommitParameters(d, field);
    EXPECT(was_told("cvol: spatial field structuredRegular: data is missing"));
    const char *missing = "/nowhere/x.cvol";
    ANARISpatialField file = anariNewSpatialField(d, "cvol");
    anariSetParameter(d, file, "file", ANARI_STRING, missing);
    anariCommitParameters(d, file);
    EXPECT(was_told("/nowhere/x.cvol"));
    anariRelease(d, file);
    anariRelease(d, field);
    field = make_field(d, &v, ANARI_FLOAT32);
    ANARIVolume volume = make_anari_volume(d, field);
    const float zero = 0;
    anariSetParameter(d, volume, "name", ANARI_STRING, "lungs");
    anariSetParameter(d, volume, "unitDistance", ANARI_FLOAT32, &zero);
    anariCommitParameters(d, volume);
    EXPECT(was_told("volume transferFunction1D 'lungs': unitDistance must be above 0"));
    anariSetParameter(d, volume, "unitDistance", ANARI_FLOAT32_VEC3, v.spacing);
    EXPECT(was_told("unitDistance is of type 1070, which this parameter does not have"));
    float sheared[16] = {1, 0, 0, 0, 0.5f, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    ANARIWorld world = make_world(d, volume, sheared);
    EXPECT(was_told("transform must be a rotation, a move, and one scale for all axes"));
    ANARICamera camera = anariNewCamera(d, "fisheye");
    EXPECT(was_told("camera fisheye: has no such subtype"));
    anariRelease(d, camera);
    ANARIFrame frame = make_frame(d, world, &c, "default", ANARI_UFIXED8_VEC4);
    anariUnsetParameter(d, frame, "world");
    anariCommitParameters(d, frame);
    anariRenderFrame(d, frame);
    EXPECT(was_told("frame: world is missing, so there is no picture"));
    const uint32_t huge[2] = {70000, 70000};
    anariSetParameter(d, frame, "world", ANARI_WORLD, &world);
    anariSetParameter(d, frame, "size", ANARI_UINT32_VEC2, huge);
    anariCommitParameters(d, frame);
    uint32_t size[2];
    EXPECT(!draw(d, frame, "channel.color", size));
    EXPECT(was_told("need a picture of more than 32768 rows or columns"));
    anariRelease(d, frame);
    anariRelease(d, world);
    anariRelease(d, volume);
    anariRelease(d, field);
    free(v.samples);
}

static void check_queries(ANARILibrary library, ANARIDevice d)
{
    int found = 0;
    for (const char **e = anariGetDeviceExtensions(library, "default"); *e; e++)
        found |= !strcmp(*e, "ANARI_KHR_VOLUME_TRANSFER_FUNCTION1D");
    EXPECT(found);
    const char **subtypes = anariGetObjectSubtypes(d, ANARI_RENDERER);
    EXPECT(!strcmp(subtypes[0], "default") && !strcmp(subtypes[1], "lit") && !subtypes[2]);
    EXPECT(!anariGetObjectSubtypes(d, ANARI_GEOMETRY)[0]);
    const ANARIParameter *p = anariGetObjectInfo(d, ANARI_CAMERA, "perspective", "parameter",
                                                 ANARI_PARAMETER_LIST);
    int has_fovy = 0, has_height = 0;
    for (; p && p->name; p++) {
        has_fovy |= !strcmp(p->name, "fovy") && p->type == ANARI_FLOAT32;
        has_height |= !strcmp(p->name, "height");
    }
    EXPECT(has_fovy && !has_height);
    const int32_t *required = anariGetParameterInfo(d, ANARI_FRAME, "", "size", ANARI_UINT32_VEC2,
                                                    "required", ANARI_BOOL);
    EXPECT(required && *required == 1);
    int32_t version = 0;
    EXPECT(anariGetProperty(d, d, "version", ANARI_INT32, &version, sizeof version, ANARI_WAIT));
    EXPECT(version > 0);
}

static int completions;

static void complete(const void *user, ANARIDevice d, ANARIFrame frame)
{
    uint32_t size[2];
    ANARIDataType type;
    EXPECT(user == &completions);
    EXPECT(anariMapFrame(d, frame, "channel.color", &size[0], &size[1], &type));
    anariUnmapFrame(d, frame, "channel.color");
    completions++;
}

static void check_frames(ANARIDevice d)
{
    volume_of_test v = make_volume();
    const view_of_test c = {0,         40,   30, {20, -45, 40}, {-0.1f, 1, -0.3f},
                            {0, 0, 1}, 0.9f, 0,  4 / 3.0f,      {0, 0, 1, 1}};
    ANARISpatialField field = make_field(d, &v, ANARI_FLOAT32);
    ANARIVolume volume = make_anari_volume(d, field);
    ANARIWorld world = make_world(d, volume, NULL);
    float box[6];
    EXPECT(anariGetProperty(d, world, "bounds", ANARI_FLOAT32_BOX3, box, sizeof box, ANARI_WAIT));
    for (int a = 0; a < 3; a++) {
        EXPECT(fabsf(box[a] - v.origin[a]) < 1e-4f);
        EXPECT(fabsf(box[3 + a] - v.origin[a] - (float)(v.dims[a] - 1) * v.spacing[a]) < 1e-4f);
    }
    /* Bytes are the floats, rounded, over the background; sRGB is brighter. */
    ANARIFrame frames[3] = {make_frame(d, world, &c, "default", ANARI_FLOAT32_VEC4),
                            make_frame(d, world, &c, "default", ANARI_UFIXED8_VEC4),
                            make_frame(d, world, &c, "default", ANARI_UFIXED8_RGBA_SRGB)};
    uint32_t size[2];
    const float *floats = draw(d, frames[0], "channel.color", size);
    const uint8_t *bytes = draw(d, frames[1], "channel.color", size);
    const uint8_t *srgb = draw(d, frames[2], "channel.color", size);
    double brighter = 0;
    for (size_t i = 0; i < 4 * 40 * 30; i++) {
        EXPECT(fabs(255 * (double)floats[i] - bytes[i]) < 0.51);
        brighter += srgb[i] - bytes[i];
    }
    EXPECT(brighter > 0);
    float duration = -1;
    EXPECT(anariGetProperty(d, frames[1], "duration", ANARI_FLOAT32, &duration, sizeof duration,
                            ANARI_WAIT));
    EXPECT(duration > 0);
    /* Renderer lit differs, and covers the same. */
    ANARIFrame lit = make_frame(d, world, &c, "lit", ANARI_UFIXED8_VEC4);
    const uint8_t *light = draw(d, lit, "channel.color", size);
    int differ = 0;
    for (size_t i = 0; i < 4 * 40 * 30; i++) {
        differ += light[i] != bytes[i];
        EXPECT(i % 4 != 3 || abs(light[i] - bytes[i]) <= 3);
    }
    EXPECT(differ > 100);
    /* The callback maps the picture. Objects may be released while a picture is drawn. */
    const ANARIFrameCompletionCallback callback = complete;
    const void *user = &completions;
    anariSetParameter(d, frames[1], "frameCompletionCallback", ANARI_FRAME_COMPLETION_CALLBACK,
                      &callback);
    anariSetParameter(d, frames[1], "frameCompletionCallbackUserData", ANARI_VOID_POINTER, &user);
    anariCommitParameters(d, frames[1]);
    for (int i = 0; i < 3; i++)
        anariRenderFrame(d, frames[1]);
    anariRelease(d, world);
    anariRelease(d, volume);
    anariRelease(d, field);
    anariRenderFrame(d, frames[0]);
    anariDiscardFrame(d, frames[0]);
    anariRelease(d, lit);
    for (int i = 0; i < 3; i++)
        anariRelease(d, frames[i]);
    EXPECT(completions >= 2);
    EXPECT(messages == 0);
    free(v.samples);
}

/* Two volumes: the nearer one hides the other. If they overlap, the device says so, once. */
static void check_order(ANARIDevice d, float distance)
{
    static float samples[8 * 8 * 8];
    for (int i = 0; i < 8 * 8 * 8; i++)
        samples[i] = 1;
    ANARIVolume volumes[2];
    for (int i = 0; i < 2; i++) {
        volume_of_test v = {{8, 8, 8}, {0, distance * (float)(1 - i), 0}, {1, 1, 1}, samples, {0},
                            0};
        ANARISpatialField field = make_field(d, &v, ANARI_FLOAT32);
        const float colour[3] = {i == 0, i == 1, 0}, opaque = 1;
        volumes[i] = anariNewVolume(d, "transferFunction1D");
        set_and_release(d, volumes[i], "value", ANARI_SPATIAL_FIELD, field);
        anariSetParameter(d, volumes[i], "color", ANARI_FLOAT32_VEC3, colour);
        anariSetParameter(d, volumes[i], "opacity", ANARI_FLOAT32, &opaque);
        anariCommitParameters(d, volumes[i]);
    }
    ANARIWorld world = anariNewWorld(d);
    set_and_release(d, world, "volume", ANARI_ARRAY1D,
                    anariNewArray1D(d, volumes, NULL, NULL, ANARI_VOLUME, 2));
    anariCommitParameters(d, world);
    for (int side = 0; side < 2; side++) {
        const view_of_test c = {0,
                                9,
                                9,
                                {3.5f, side ? 60.0f : -40.0f, 3.5f},
                                {0, side ? -1.0f : 1.0f, 0},
                                {0, 0, 1},
                                0.2f,
                                0,
                                1,
                                {0, 0, 1, 1}};
        ANARIFrame frame = make_frame(d, world, &c, "default", ANARI_FLOAT32_VEC4);
        uint32_t size[2];
        const float *p = draw(d, frame, "channel.color", size);
        const float *middle = p + 4 * (4 + 9 * 4);
        EXPECT(p && middle[3] > 0.99f && middle[side ? 0 : 1] > 0.99f &&
               middle[side ? 1 : 0] < 0.01f);
        if (distance < 7) {
            draw(d, frame, "channel.color", size);
            EXPECT(was_told("volumes overlap"));
        }
        anariRelease(d, frame);
    }
    anariRelease(d, world);
    anariRelease(d, volumes[0]);
    anariRelease(d, volumes[1]);
    EXPECT(messages == 0);
}

/* ---- failures -------------------------------------------------------------------------------- */

static int no_threads; /* as if a limit of threads were reached */

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                   void *user)
{
    static int (*create)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    if (no_threads)
        return EAGAIN;
    if (!create)
        *(void **)&create = dlsym(RTLD_NEXT, "pthread_create");
    return create(thread, attributes, run, user);
}

/* Without a thread there is a message, the last picture stays, and waiting ends. */
static void check_threads(ANARIDevice d)
{
    volume_of_test v = make_volume();
    const view_of_test c = {0, 8, 8, {20, -45, 40}, {0, 1, 0}, {0, 0, 1}, 0.9f, 0, 1, {0, 0, 1, 1}};
    ANARISpatialField field = make_field(d, &v, ANARI_FLOAT32);
    ANARIVolume volume = make_anari_volume(d, field);
    ANARIWorld world = make_world(d, volume, NULL);
    ANARIFrame frame = make_frame(d, world, &c, "default", ANARI_UFIXED8_VEC4);
    uint32_t size[2];
    for (int last = 0; last < 2; last++) {
        no_threads = 1;
        anariRenderFrame(d, frame);
        no_threads = 0;
        EXPECT(was_told("frame: cannot start a thread that draws"));
        EXPECT(anariFrameReady(d, frame, ANARI_WAIT) == 1);
        ANARIDataType type;
        EXPECT(last == (anariMapFrame(d, frame, "channel.color", &size[0], &size[1], &type) != 0));
        EXPECT(draw(d, frame, "channel.color", size));
    }
    anariRelease(d, frame);
    anariRelease(d, world);
    anariRelease(d, volume);
    anariRelease(d, field);
    free(v.samples);
}

/* The application gives away an array that the device has no memory to copy: it says so. Memory
 * with a deleter stays until the array is freed. */
static void check_large_memory(ANARIDevice d)
{
    const size_t bytes = sizeof(float) * 512 * 256 * 256;
    void *samples = mmap(NULL, bytes, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1,
                         0);
    EXPECT(samples != MAP_FAILED);
    for (int has_deleter = 0; has_deleter < 2; has_deleter++) {
        ANARISpatialField field = anariNewSpatialField(d, "structuredRegular");
        ANARIArray3D data = anariNewArray3D(d, samples, has_deleter ? delete_samples : NULL,
                                            &deleted, ANARI_FLOAT32, 512, 256, 256);
        anariSetParameter(d, field, "data", ANARI_ARRAY3D, &data);
        unsigned long pages = 0;
        FILE *file = fopen("/proc/self/statm", "r");
        EXPECT(file && fscanf(file, "%lu", &pages) == 1);
        if (file)
            fclose(file);
        struct rlimit before, less;
        getrlimit(RLIMIT_AS, &before);
        less = before;
        less.rlim_cur = pages * (rlim_t)sysconf(_SC_PAGESIZE) + bytes / 2;
        setrlimit(RLIMIT_AS, &less);
        deleted = 0;
        anariRelease(d, data);
        setrlimit(RLIMIT_AS, &before);
        EXPECT(deleted == 0);
        if (has_deleter)
            EXPECT(messages == 0);
        else {
            EXPECT(was_told("no memory for a copy of what the application shared"));
            anariCommitParameters(d, field);
            EXPECT(was_told("data: axis x has 0 samples"));
        }
        anariRelease(d, field);
        EXPECT(deleted == has_deleter);
    }
    munmap(samples, bytes);
}

/* Devices of several threads list parameters at the same time. */
static pthread_barrier_t start;

static void *list_parameters(void *user)
{
    ANARIDevice d = user;
    void *wrong = NULL;
    pthread_barrier_wait(&start);
    for (int i = 0; i < 20000; i++) {
        char subtype[40];
        snprintf(subtype, sizeof subtype, "%d of %p", i, i % 2 ? user : NULL);
        const ANARIParameter *p = anariGetObjectInfo(d, ANARI_CAMERA, subtype, "parameter",
                                                     ANARI_PARAMETER_LIST);
        if (!p || strcmp(p->name, "name"))
            wrong = user;
    }
    return wrong;
}

static void check_devices(ANARILibrary library)
{
    enum { DEVICES = 4 };
    ANARIDevice devices[DEVICES];
    pthread_t threads[DEVICES];
    pthread_barrier_init(&start, NULL, DEVICES);
    for (int i = 0; i < DEVICES; i++) {
        devices[i] = anariNewDevice(library, "default");
        EXPECT(!pthread_create(&threads[i], NULL, list_parameters, devices[i]));
    }
    for (int i = 0; i < DEVICES; i++) {
        void *wrong = devices[i];
        EXPECT(!pthread_join(threads[i], &wrong) && !wrong);
        anariRelease(devices[i], devices[i]);
    }
    pthread_barrier_destroy(&start);
}

/* ---- files ----------------------------------------------------------------------------------- */

static void write_picture(const char *path, const uint8_t *rgba, const uint32_t size[2])
{
    FILE *file = fopen(path, "wb");
    if (!file)
        return;
    fprintf(file, "P6 %u %u 255\n", size[0], size[1]);
    for (uint32_t y = size[1]; y-- > 0;)
        for (uint32_t x = 0; x < size[0]; x++)
            fwrite(rgba + 4 * (x + (size_t)size[0] * y), 1, 3, file);
    fclose(file);
}

/* Sets the grid of a volume to that of a field of a file, by its bounds. */
static void find_grid(ANARIDevice d, volume_of_test *v, ANARISpatialField field)
{
    float box[6] = {0};
    ANARIVolume volume = make_anari_volume(d, field);
    EXPECT(anariGetProperty(d, volume, "bounds", ANARI_FLOAT32_BOX3, box, sizeof box, ANARI_WAIT));
    for (int a = 0; a < 3; a++) {
        v->origin[a] = box[a];
        v->spacing[a] = (box[3 + a] - box[a]) / (float)(v->dims[a] - 1);
    }
    anariRelease(d, volume);
}

static float *read_samples(const char *path, size_t count)
{
    uint8_t *bytes = malloc(count);
    float *samples = malloc(count * sizeof *samples);
    FILE *file = fopen(path, "rb");
    EXPECT(file && fread(bytes, 1, count, file) == count);
    if (file)
        fclose(file);
    for (size_t i = 0; i < count; i++)
        samples[i] = bytes[i];
    free(bytes);
    return samples;
}

enum { SIDE = 400 };

/* A picture of a field, from the right, the front and above. The caller frees it. */
static uint8_t *draw_field(ANARIDevice d, const volume_of_test *v, ANARISpatialField field,
                           const char *path)
{
    const float far = 2 * (float)v->dims[1] * v->spacing[1];
    view_of_test c = {0,         SIDE, SIDE, {0}, {-0.8f, -1.1f, -0.5f},
                      {0, 0, 1}, 0.6f, 0,    1,   {0, 0, 1, 1}};
    for (int a = 0; a < 3; a++)
        c.position[a] = v->origin[a] + (float)v->dims[a] * v->spacing[a] / 2 - far * c.direction[a];
    ANARIVolume volume = make_anari_volume(d, field);
    ANARIWorld world = make_world(d, volume, NULL);
    ANARIFrame frame = make_frame(d, world, &c, "lit", ANARI_UFIXED8_VEC4);
    uint32_t size[2] = {0, 0};
    const uint8_t *drawn = draw(d, frame, "channel.color", size);
    uint8_t *copy = calloc(4, (size_t)SIDE * SIDE);
    EXPECT(drawn && size[0] == SIDE && size[1] == SIDE);
    if (drawn)
        memcpy(copy, drawn, (size_t)4 * SIDE * SIDE);
    if (path)
        write_picture(path, copy, size);
    anariRelease(d, frame);
    anariRelease(d, world);
    anariRelease(d, volume);
    return copy;
}

/* A field of a file is that of its samples, up to compression. */
static void check_file(ANARIDevice d, char **arguments, const char *picture)
{
    volume_of_test v = {
        {atoi(arguments[2]), atoi(arguments[3]), atoi(arguments[4])}, {0}, {0}, NULL, {0}, 0};
    v.samples = read_samples(arguments[1],
                             (size_t)v.dims[0] * (size_t)v.dims[1] * (size_t)v.dims[2]);
    range[0] = 20, range[1] = 160;
    ANARISpatialField of_file = anariNewSpatialField(d, "cvol");
    anariSetParameter(d, of_file, "file", ANARI_STRING, arguments[0]);
    anariCommitParameters(d, of_file);
    find_grid(d, &v, of_file);
    ANARISpatialField of_samples = make_field(d, &v, ANARI_FLOAT32);
    uint8_t *first = draw_field(d, &v, of_file, picture);
    uint8_t *second = draw_field(d, &v, of_samples, NULL);
    double sum = 0, seen = 0;
    for (size_t i = 0; i < (size_t)4 * SIDE * SIDE; i++) {
        sum += abs(first[i] - second[i]);
        seen += first[i] > 20;
    }
    printf("a file and its samples: mean difference %.3f of 255\n", sum / 4 / SIDE / SIDE);
    EXPECT(sum < 1.0 * 4 * SIDE * SIDE);
    EXPECT(seen > 0.5 * SIDE * SIDE);
    EXPECT(messages == 0);
    anariRelease(d, of_file);
    anariRelease(d, of_samples);
    free(first);
    free(second);
    free(v.samples);
}

int main(int argc, char **argv)
{
    if (argc < 6) {
        printf("usage: anari_client FILE.cvol SAMPLES.raw NX NY NZ [PICTURE.ppm]\n");
        return 2;
    }
    ANARILibrary library = anariLoadLibrary("environment", receive, NULL);
    EXPECT(library != NULL);
    ANARIDevice d = library ? anariNewDevice(library, "default") : NULL;
    EXPECT(d != NULL);
    if (!d)
        return 1;
    check_queries(library, d);
    check_pictures(d);
    EXPECT(messages == 0);
    check_memory(d);
    check_messages(d);
    check_frames(d);
    check_order(d, 20);
    check_order(d, 6);
    check_threads(d);
    check_large_memory(d);
    check_devices(library);
    check_file(d, argv + 1, argc > 6 ? argv[6] : NULL);
    anariRelease(d, d);
    anariUnloadLibrary(library);
    if (failures)
        printf("anari_client: %d failures\n", failures);
    return failures ? 1 : 0;
}
