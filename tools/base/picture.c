/* Pictures: reads PNG and compressed pictures, and converts between them. */
#include "tools/base/picture.h"

#include <string.h>
#include <unistd.h>

int is_picture(const char *path)
{
    return is_png(path) || kind_of(path) == CVOL_FILE_PICTURE;
}

int read_picture(cvol_context *context, cvol_image **image, const char *path)
{
    cvol_picture *picture;
    *image = NULL;
    if (is_png(path))
        return cvol_image_read_png(context, image, path);
    int code = cvol_picture_read(context, &picture, path);
    if (!code)
        code = cvol_picture_evaluate(context, image, picture);
    cvol_picture_free(picture);
    return code;
}

json_t *describe_picture(const cvol_picture_info *info)
{
    return json_pack(
        "{s:s, s:i, s:i, s:[I, I], s:i, s:s, s:o, s:s, s:i, s:f, s:I, s:f, s:f, s:f, s:I, s:I, "
        "s:o, s:b, s:o, s:o}",
        "kind", "picture", "width", info->width, "height", info->height, "lattice",
        (json_int_t)info->lattice[0], (json_int_t)info->lattice[1], "planes", info->planes,
        "opacity",
        info->planes < 4 ? "none"
        : info->is_over  ? "over the background"
                         : "its own",
        "background", json_triple(info->background), "transform",
        cvol_transform_name(info->transform), "block", info->block, "step", info->step,
        "coefficients", (json_int_t)info->terms, "rho", info->rho, "ratio", info->ratio,
        "bits_per_pixel", 8 * (double)info->file_bytes / ((double)info->width * info->height),
        "file_bytes", (json_int_t)info->file_bytes, "resident_bytes",
        (json_int_t)info->resident_bytes, "psnr_db", json_decibels(info->psnr_db), "exact",
        is_exact(info->psnr_db), "l2_error", json_number(info->l2_error), "rms_bound",
        json_number(info->rms_bound));
}

int compress_picture(cvol_context *context, const char *in_path, const char *out_path,
                     const cvol_picture_options *options, int json)
{
    cvol_image *image = NULL;
    cvol_picture *picture = NULL;
    cvol_picture_info info;
    char psnr[PSNR_TEXT];
    int code = cvol_image_read_png(context, &image, in_path);
    if (code)
        return report_context_error(context, code, NULL);
    code = cvol_picture_compress(context, &picture, image, options);
    if (code)
        code = report_context_error(context, code, in_path);
    else if ((code = cvol_picture_get_info(context, &info, picture)) ||
             (code = cvol_picture_write(context, picture, out_path, NULL)))
        code = report_context_error(context, code, NULL);
    clear_progress();
    if (!code && json)
        code = print_json(describe_picture(&info));
    else if (!code)
        printf("%s: %llu bytes, 1/%.1f of the pixels, %s\n", out_path,
               (unsigned long long)info.file_bytes, info.ratio, psnr_text(psnr, info.psnr_db));
    cvol_picture_free(picture);
    cvol_image_free(image);
    return code;
}

int decompress_picture(cvol_context *context, const char *in_path, const char *out_path, int json)
{
    cvol_image *image = NULL;
    int status = check_output(in_path, out_path);
    if (status)
        return status;
    const double start = milliseconds();
    int code = read_picture(context, &image, in_path);
    const double decode_ms = milliseconds() - start;
    if (!code)
        code = cvol_image_write_png(context, image, out_path);
    clear_progress();
    if (code)
        status = report_context_error(context, code, NULL);
    else if (json)
        status = print_json(json_pack("{s:o, s:i, s:i, s:f}", "output", json_text(out_path),
                                      "width", image->width, "height", image->height, "decode_ms",
                                      decode_ms));
    else
        printf("%s: %d x %d\n", out_path, image->width, image->height);
    cvol_image_free(image);
    return status;
}
