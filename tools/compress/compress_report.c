/* cvol compress: the report on one volume, as text and as JSON. */
#include "tools/compress/compress.h"

static double bits_per_voxel(const cvol_grid *grid, const cvol_compress_report *report)
{
    return 8 * (double)report->file_bytes / (double)cvol_grid_samples(grid);
}

int report_one_json(const cvol_grid *grid, const cvol_array_info *info,
                    const cvol_compress_report *report, int by_slab, int has_yielded)
{
    return print_json(json_pack(
        "{s:o, s:s, s:I, s:f, s:f, s:o, s:b, s:f, s:b, s:b, s:b, s:i, s:f, s:I, s:f, "
        "s:s, s:i, s:o, s:o, s:o, s:b, s:o, s:I}",
        "dims", json_dims(grid->dims), "type", cvol_type_name(grid->type), "file_bytes",
        (json_int_t)report->file_bytes, "ratio", report->ratio, "bits_per_voxel",
        bits_per_voxel(grid, report), "psnr_db", json_decibels(report->psnr_db), "exact",
        is_exact(report->psnr_db), "max_error", report->max_error, "lossless", report->lossless,
        "target_met", report->target_met, "yielded_to_psnr", has_yielded, "block", info->block,
        "step", info->step, "coefficients", (json_int_t)info->coefficients, "rho", info->rho,
        "transform", cvol_transform_name(info->transform), "rank", info->rank, "low",
        json_dims(info->low), "l2_error", json_number(info->l2_error), "point_error",
        json_number(info->point_error), "by_slab", by_slab, "background",
        report->background_samples ? json_real(report->background) : json_null(),
        "background_samples", (json_int_t)report->background_samples));
}

double size_wanted(const method *m, const cvol_grid *grid, const cvol_compress_report *report)
{
    const double raw_bytes = (double)cvol_grid_bytes(grid), value = m->options.target_value;
    return m->options.target == CVOL_TARGET_RATIO  ? raw_bytes / value / (double)report->file_bytes
           : m->options.target == CVOL_TARGET_BITS ? value / bits_per_voxel(grid, report)
                                                   : 0;
}

/* Reports a target by size that was missed; `target` names it, and `wanted`: see size_wanted. */
static void report_miss(const cvol_compress_report *report, const char *target, double wanted)
{
    if (report->lossless && wanted > 1.02)
        printf("(the file is lossless and smaller than the target, %s)\n", target);
    else if (report->target_met)
        return;
    else if (report->lossless)
        printf("(%s is out of reach: the file is lossless, and lossy ones are not smaller)\n",
               target);
    else if (wanted >= 1)
        printf("(%s is out of reach: the finest lossy file is smaller; give --lossless for more "
               "quality)\n",
               target);
    else
        printf("(%s is out of reach: this is the smallest possible file; give --psnr or --lossless "
               "for more quality)\n",
               target);
}

void report_one_text(const char *path, const method *m, const cvol_grid *grid,
                     const cvol_compress_report *report, int has_yielded)
{
    const double target_value = m->options.target_value;
    char target[64], share[SHARE_TEXT];
    clear_progress();
    printf("%s: %llu bytes, %s, %.4g bits per voxel, ", path,
           (unsigned long long)report->file_bytes, share_text(share, report->ratio),
           bits_per_voxel(grid, report));
    if (report->lossless)
        printf("exact");
    else
        printf("PSNR %.2f dB, largest error %g", report->psnr_db, report->max_error);
    if (report->background_samples)
        printf(", background %g stored separately", report->background);
    printf("\n");
    if (m->truncate || m->options.lossless || has_yielded)
        return;
    snprintf(target, sizeof target,
             m->options.target == CVOL_TARGET_BITS ? "%g bits per voxel" : "ratio %g",
             target_value);
    report_miss(report, target, size_wanted(m, grid, report));
}
