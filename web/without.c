/* Functions of libcvol that this build is without, to keep it small: file formats other than .cvol,
 * compressing, and the engines other than sheet. */
#include "base/context.h"
#include "cvol/codec.h"
#include "render/engine/engine.h"
#include "volume/formats/nifti_intent.h"
#include "volume/formats/vdb/labels.h"
#include "volume/formats/zarr/labels.h"

static int refuse(cvol_context *context, const char *what)
{
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED, "this build does not %s", what);
}

/* ---- files and compressing --------------------------------------------------------------------
 */

int cvol_volume_read(cvol_context *context, cvol_volume **out, const char *path,
                     const cvol_read_options *options)
{
    (void)options;
    *out = NULL;
    return cvol_fail(context, CVOL_ERROR_UNSUPPORTED, "%s: is not a .cvol file", path);
}

int cvol_nifti_find_label_intent(cvol_context *context, int *out, const char *path)
{
    (void)context, (void)path;
    *out = 0;
    return CVOL_OK;
}

int cvol_zarr_find_label_mark(cvol_context *context, int *out, const char *path)
{
    (void)context, (void)path;
    *out = 0;
    return CVOL_OK;
}

int cvol_vdb_find_label_mark(cvol_context *context, int *out, cvol_type type, const char *path)
{
    (void)context, (void)type, (void)path;
    *out = 0;
    return CVOL_OK;
}

int cvol_compress(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                  const void *samples, const cvol_grid *grid, const cvol_compress_options *options)
{
    (void)report, (void)samples, (void)grid, (void)options;
    *out = NULL;
    return refuse(context, "compress");
}

int cvol_array_transcode(cvol_context *context, cvol_array **out, cvol_compress_report *report,
                         const cvol_array *array, const cvol_compress_options *options)
{
    (void)report, (void)array, (void)options;
    *out = NULL;
    return refuse(context, "compress");
}

int cvol_array_flatten(cvol_context *context, cvol_array **out, const cvol_array *array)
{
    (void)array;
    *out = NULL;
    return refuse(context, "compress");
}

/* ---- engines ----------------------------------------------------------------------------------
 */

const cvol_engine_table cvol_ray_engine = {0};
const cvol_engine_table cvol_splat_engine = {0};
const cvol_engine_table cvol_transform_engine = {0};
const cvol_engine_table cvol_fourier_engine = {0};

static int refuse_engine(cvol_context *context, void **state)
{
    *state = NULL;
    return refuse(context, "have this engine");
}

int cvol_splat_create(cvol_context *context, void **state, const cvol_array *array)
{
    (void)array;
    return refuse_engine(context, state);
}

int cvol_splat_create_dense(cvol_context *context, void **state, const cvol_volume *volume)
{
    (void)volume;
    return refuse_engine(context, state);
}

int cvol_ray_create(cvol_context *context, void **state, const cvol_volume *volume,
                    const uint8_t *mask)
{
    (void)volume, (void)mask;
    return refuse_engine(context, state);
}

int cvol_transform_create(cvol_context *context, void **state, const cvol_array *array)
{
    (void)array;
    return refuse_engine(context, state);
}

int cvol_transform_create_dense(cvol_context *context, void **state, const cvol_volume *volume)
{
    (void)volume;
    return refuse_engine(context, state);
}

int cvol_transform_create_baked(cvol_context *context, void **state, const char *path)
{
    (void)path;
    return refuse_engine(context, state);
}

int cvol_fourier_create(cvol_context *context, void **state, const cvol_array *array, double rho)
{
    (void)array, (void)rho;
    return refuse_engine(context, state);
}

int cvol_fourier_create_dense(cvol_context *context, void **state, const cvol_volume *volume,
                              double rho)
{
    (void)volume, (void)rho;
    return refuse_engine(context, state);
}

/* These have a state, which no engine here makes. */

const cvol_grid *cvol_transform_baked_grid(const void *state)
{
    return state;
}

int cvol_transform_picture(cvol_context *context, void *state, cvol_picture **out,
                           const cvol_view *view, const cvol_render_options *options,
                           const cvol_picture_options *how)
{
    (void)state, (void)view, (void)options, (void)how;
    *out = NULL;
    return refuse(context, "have this engine");
}

void cvol_ray_range(const void *state, double range[2])
{
    (void)state;
    range[0] = range[1] = 0;
}

void cvol_fourier_range(const void *state, double range[2])
{
    cvol_ray_range(state, range);
}
