/* Writes and reads compressed pictures: sections PICT and PLNS. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/file.h"
#include "codec/container/picture.h"
#include "codec/container/plane_file.h"

void cvol_picture_free(cvol_picture *picture)
{
    for (int c = 0; picture && c < CVOL_PICTURE_PLANES; c++)
        cvol_array_free(picture->planes[c]);
    free(picture);
}

const cvol_array *cvol_picture_plane(const cvol_picture *picture, int plane)
{
    return plane >= 0 && plane < picture->plane_count ? picture->planes[plane] : NULL;
}

static cvol_plane_shape shape_of(const cvol_picture *picture)
{
    return (cvol_plane_shape){
        {picture->lattice[0], picture->lattice[1]}, picture->transform, picture->block};
}

/* Planes of one class share probabilities: the first plane, the other colours, opacity. */
static int class_of(int plane)
{
    return plane == 0 ? 0 : plane < CVOL_PICTURE_OPACITY ? 1 : 2;
}

enum { CLASSES = 3 };

/* ---- writing -------------------------------------------------------------------------------- */

static void put_head(cvol_bytes *out, const cvol_picture *picture)
{
    cvol_bytes_put_u32(out, (uint32_t)picture->width);
    cvol_bytes_put_u32(out, (uint32_t)picture->height);
    cvol_bytes_put_u32(out, (uint32_t)picture->lattice[0]);
    cvol_bytes_put_u32(out, (uint32_t)picture->lattice[1]);
    cvol_bytes_put_u32(out, (uint32_t)picture->transform);
    cvol_bytes_put_u32(out, (uint32_t)picture->block);
    cvol_bytes_put_u32(out, (uint32_t)picture->plane_count);
    cvol_bytes_put_u32(out, (uint32_t)picture->is_over);
    for (int a = 0; a < 2; a++)
        for (int i = 0; i < 3; i++)
            cvol_bytes_put_f64(out, picture->to_intermediate[a][i]);
    for (int c = 0; c < 3; c++)
        cvol_bytes_put_f64(out, picture->background[c]);
    cvol_bytes_put_f64(out, picture->psnr_db);
    for (int c = 0; c < picture->plane_count; c++) {
        const cvol_error_bound *error_bound = &picture->planes[c]->error_bound;
        cvol_bytes_put_f64(out, picture->steps[c]);
        cvol_bytes_put_f64(out, error_bound->l2_error);
        cvol_bytes_put_f64(out, error_bound->value_min);
        cvol_bytes_put_f64(out, error_bound->value_max);
    }
}

static int put_planes(cvol_context *context, cvol_bytes *out, const cvol_picture *picture)
{
    const cvol_plane_shape shape = shape_of(picture);
    cvol_tile_contexts contexts[CLASSES];
    cvol_range_encoder encoder = {0};
    int code = CVOL_OK;
    for (int i = 0; i < CLASSES; i++)
        cvol_tile_contexts_start(&contexts[i]);
    cvol_range_encoder_start(&encoder);
    for (int c = 0; c < picture->plane_count && !code; c++) {
        const cvol_tile_coder coder = {.encoder = &encoder, .contexts = &contexts[class_of(c)]};
        int32_t *values;
        code = cvol_plane_values(context, &values, picture->planes[c], picture->steps[c]);
        if (!code)
            (void)cvol_plane_code(&coder, values, NULL, &shape);
        free(values);
    }
    if (!code && !cvol_range_encoder_finish(&encoder, out))
        code = cvol_fail_memory(context, out->size, "a picture");
    cvol_range_encoder_free(&encoder);
    return code;
}

int cvol_picture_put(cvol_context *context, cvol_bytes *out, const cvol_picture *picture)
{
    cvol_bytes head = {0}, planes = {0};
    put_head(&head, picture);
    int code = put_planes(context, &planes, picture);
    if (!code)
        code = cvol_plane_file_put(context, out, CVOL_PICT, &head, &planes);
    cvol_bytes_free(&head);
    cvol_bytes_free(&planes);
    return code;
}

int cvol_picture_write(cvol_context *context, const cvol_picture *picture, const char *path,
                       uint64_t *file_bytes)
{
    cvol_bytes bytes = {0};
    const int code = cvol_picture_put(context, &bytes, picture);
    return cvol_plane_file_end(context, &bytes, code, path, file_bytes);
}

/* ---- reading -------------------------------------------------------------------------------- */

/* A plane's record in the head. */
typedef struct plane_record {
    double step;
    cvol_error_bound error_bound;
} plane_record;

static int fail(cvol_context *context, const char *name, const char *what)
{
    return cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section PICT: %s", name, what);
}

/* Reads sizes and options. Returns an error text, or NULL. */
static const char *take_shape(cvol_picture *picture, cvol_cursor *content)
{
    uint32_t fields[8];
    for (int i = 0; i < 8; i++)
        fields[i] = cvol_cursor_u32(content);
    if (content->failed)
        return "is too short";
    for (int i = 0; i < 2; i++)
        if (!fields[i] || fields[i] > CVOL_IMAGE_SIZE_MAX)
            return "width and height must be 1 to 32768";
    for (int i = 2; i < 4; i++)
        if (!fields[i] || fields[i] > 2 * CVOL_IMAGE_SIZE_MAX)
            return "the lattice must have 1 to 65536 places along each axis";
    if (fields[4] < CVOL_DCT || fields[4] > CVOL_DFT)
        return "the transform is unknown";
    if (fields[5] != 0 && fields[5] != 8 && fields[5] != 16 && fields[5] != 32)
        return "the side of tiles must be 0, 8, 16 or 32";
    if (fields[6] != CVOL_PICTURE_COLOURS && fields[6] != CVOL_PICTURE_PLANES)
        return "there must be three or four planes";
    if (fields[7] > 1 || (fields[7] && fields[6] != CVOL_PICTURE_PLANES))
        return "over must be 0, or 1 with four planes";
    if (!fields[7] && (fields[0] != fields[2] || fields[1] != fields[3]))
        return "the lattice must be that of the pixels if over is 0";
    picture->width = (int)fields[0];
    picture->height = (int)fields[1];
    picture->lattice[0] = fields[2];
    picture->lattice[1] = fields[3];
    picture->transform = (cvol_transform)fields[4];
    picture->block = (int)fields[5];
    picture->plane_count = (int)fields[6];
    picture->is_over = (int)fields[7];
    return NULL;
}

static const char *take_numbers(cvol_picture *picture, plane_record *records, cvol_cursor *content)
{
    int sound = 1;
    for (int i = 0; i < 6; i++) {
        const double value = cvol_cursor_f64(content);
        sound &= isfinite(value);
        picture->to_intermediate[i / 3][i % 3] = value;
    }
    for (int c = 0; c < 3; c++) {
        picture->background[c] = cvol_cursor_f64(content);
        sound &= picture->background[c] >= 0 && picture->background[c] <= 1;
    }
    picture->psnr_db = cvol_cursor_f64(content);
    if (picture->psnr_db >= CVOL_PSNR_EXACT)
        picture->psnr_db = (double)INFINITY;
    sound &= !isnan(picture->psnr_db) && picture->psnr_db > -1e300;
    for (int c = 0; c < picture->plane_count; c++) {
        plane_record *record = &records[c];
        cvol_error_bound *error_bound = &record->error_bound;
        *record = (plane_record){.step = cvol_cursor_f64(content)};
        error_bound->l2_error = cvol_cursor_f64(content);
        error_bound->value_min = cvol_cursor_f64(content);
        error_bound->value_max = cvol_cursor_f64(content);
        sound &= record->step > 0 && record->step <= 1e30 && error_bound->l2_error >= 0 &&
                 error_bound->l2_error <= 1e30 && error_bound->value_min >= -1e30 &&
                 error_bound->value_min <= error_bound->value_max && error_bound->value_max <= 1e30;
        error_bound->max_abs = cvol_error_bound_largest(error_bound) + error_bound->l2_error;
    }
    return content->failed ? "is too short"
           : sound         ? NULL
                           : "has a number that is invalid or out of range";
}

static int take_planes(cvol_context *context, cvol_picture *picture, const plane_record *records,
                       const cvol_section *section, const char *name)
{
    const cvol_plane_shape shape = shape_of(picture);
    cvol_tile_contexts contexts[CLASSES];
    cvol_range_decoder decoder;
    int code = cvol_plane_file_check(context, &shape, (uint64_t)picture->plane_count,
                                     section->length, name);
    if (code)
        return code;
    const size_t places = (size_t)cvol_plane_places(&shape);
    int32_t *values = malloc(places * sizeof *values);
    if (!values)
        return cvol_fail_memory(context, places * sizeof *values, "a picture");
    for (int i = 0; i < CLASSES; i++)
        cvol_tile_contexts_start(&contexts[i]);
    cvol_range_decoder_start(&decoder, section->content, (size_t)section->length);
    for (int c = 0; c < picture->plane_count && !code; c++) {
        const cvol_tile_coder coder = {.decoder = &decoder, .contexts = &contexts[class_of(c)]};
        if (!cvol_plane_code(&coder, values, NULL, &shape) || cvol_range_decoder_overrun(&decoder))
            code = cvol_fail(context, CVOL_ERROR_CORRUPT, "%s: section PLNS: plane %d is damaged",
                             name, c);
        picture->steps[c] = records[c].step;
        if (!code)
            code = cvol_plane_array(context, &picture->planes[c], values, &shape, records[c].step,
                                    name);
        if (!code)
            picture->planes[c]->error_bound = records[c].error_bound;
        if (!code)
            cvol_array_derive_figures(picture->planes[c]);
    }
    free(values);
    return code;
}

int cvol_picture_take(cvol_context *context, cvol_picture **out, const uint8_t *data, size_t size,
                      const char *name)
{
    cvol_section head, planes;
    plane_record records[CVOL_PICTURE_PLANES];
    *out = NULL;
    int code = cvol_plane_file_take(context, &head, &planes, CVOL_PICT, data, size, name);
    if (code)
        return code;
    cvol_picture *picture = calloc(1, sizeof *picture);
    if (!picture)
        return cvol_fail_memory(context, sizeof *picture, "a picture");
    cvol_cursor content = cvol_section_cursor(&head);
    const char *wrong = take_shape(picture, &content);
    if (!wrong)
        wrong = take_numbers(picture, records, &content);
    code = wrong ? fail(context, name, wrong)
                 : take_planes(context, picture, records, &planes, name);
    if (code)
        cvol_picture_free(picture);
    else
        *out = picture;
    return code;
}

int cvol_picture_read(cvol_context *context, cvol_picture **out, const char *path)
{
    cvol_map file;
    *out = NULL;
    int code = cvol_file_map(context, &file, path);
    if (code)
        return code;
    code = cvol_picture_take(context, out, file.data, file.size, path);
    cvol_file_unmap(&file);
    return code;
}

/* ---- describing ----------------------------------------------------------------------------- */

int cvol_picture_get_info(cvol_context *context, cvol_picture_info *out,
                          const cvol_picture *picture)
{
    cvol_bytes bytes = {0};
    double squares = 0;
    const double places = (double)picture->lattice[0] * (double)picture->lattice[1];
    const int channels = picture->is_over || picture->plane_count == CVOL_PICTURE_COLOURS ? 3 : 4;
    *out = (cvol_picture_info){.width = picture->width,
                               .height = picture->height,
                               .lattice = {picture->lattice[0], picture->lattice[1]},
                               .planes = picture->plane_count,
                               .is_over = picture->is_over,
                               .transform = picture->transform,
                               .block = picture->block,
                               .step = picture->steps[0],
                               .resident_bytes = sizeof *picture,
                               .psnr_db = picture->psnr_db};
    memcpy(out->background, picture->background, sizeof out->background);
    for (int c = 0; c < picture->plane_count; c++) {
        cvol_array_info info;
        cvol_array_get_info(&info, picture->planes[c]);
        out->terms += info.coefficients;
        out->resident_bytes += info.resident_bytes;
        squares += c < CVOL_PICTURE_COLOURS ? info.l2_error * info.l2_error : 0;
    }
    out->rho = (double)out->terms / (places * picture->plane_count);
    out->l2_error = sqrt(squares);
    out->rms_bound = out->l2_error / sqrt(places * CVOL_PICTURE_COLOURS);
    int code = cvol_picture_put(context, &bytes, picture);
    out->file_bytes = bytes.size;
    out->ratio = (double)picture->width * picture->height * channels / (double)bytes.size;
    cvol_bytes_free(&bytes);
    return code;
}
