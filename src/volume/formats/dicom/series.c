/* Slices of a DICOM series: files of one series instance UID and number, whose frames are sorted by
 * their positions along the slices' normal (PS3.3 C.7.6.2: image plane). Several frames at one
 * position are volumes of a time series, sorted by acquisition and instance. */
#define _GNU_SOURCE
#include "volume/formats/dicom/series.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "volume/io/folder.h"
#include "volume/io/format.h"
#include "volume/io/geometry.h"

void cvol_dicom_series_close(cvol_dicom_series *series)
{
    for (size_t i = 0; i < series->head_count; i++)
        cvol_dicom_head_close(&series->heads[i]);
    free(series->heads);
    free(series->slices);
    *series = (cvol_dicom_series){.count = 0};
}

/* ---- files ---------------------------------------------------------------------------- */

static int add_head(cvol_context *context, cvol_dicom_series *series, const char *path)
{
    size_t n = series->head_count;
    if ((n & (n - 1)) == 0) {
        size_t room = n ? 2 * n : 1;
        cvol_dicom_head *heads = realloc(series->heads, room * sizeof *heads);
        if (!heads)
            return cvol_fail_memory(context, room * sizeof *heads, path);
        series->heads = heads;
    }
    cvol_dicom_head *head = &series->heads[n];
    int code = cvol_dicom_head_read(context, head, path);
    if (!code && head->has_pixels) {
        series->head_count++;
        return CVOL_OK;
    }
    cvol_dicom_head_close(head); /* reports, directories and the like have no pixels */
    return code;
}

static int is_dicom(cvol_context *context, const char *path)
{
    uint8_t bytes[132];
    size_t got = 0;
    cvol_input input;
    int is = !cvol_input_open(context, &input, path) &&
             !cvol_input_read(context, &input, 0, bytes, sizeof bytes, &got) &&
             cvol_dicom_recognise(bytes, got);
    cvol_input_close(&input);
    return is;
}

static int list_folder(cvol_context *context, cvol_dicom_series *series, const char *folder_path,
                       const char *but)
{
    cvol_folder folder;
    int code = cvol_folder_open(context, &folder, folder_path);
    for (size_t i = 0; !code && i < folder.count; i++) {
        const int same = but && !strcmp(cvol_input_name(but), cvol_input_name(folder.paths[i]));
        /* A file that looks like a slice but cannot be read is an error: otherwise a gap would be
         * unnoticed. */
        if (!same &&
            (is_dicom(context, folder.paths[i]) || cvol_folder_name_ends(folder.paths[i], ".dcm")))
            code = add_head(context, series, folder.paths[i]);
        if (!code)
            code = cvol_report_progress(context, "reading slices' headers",
                                        (double)(i + 1) / (double)folder.count);
    }
    cvol_folder_close(&folder);
    return code;
}

int cvol_dicom_series_list(cvol_context *context, cvol_dicom_series *series, const char *path,
                           size_t *first)
{
    int is_folder, code = cvol_folder_check(context, &is_folder, path);
    *first = SIZE_MAX;
    if (code)
        return code;
    if (is_folder)
        return list_folder(context, series, path, NULL);
    code = add_head(context, series, path);
    if (code)
        return code;
    if (!series->head_count)
        return cvol_fail(context, CVOL_ERROR_UNSUPPORTED, "%s: is a DICOM file without an image",
                         path);
    *first = 0;
    if (series->heads[0].frames > 1) /* a separate volume */
        return CVOL_OK;
    char *folder = cvol_input_relative_path(path, ".");
    if (!folder)
        return cvol_fail_memory(context, strlen(path), path);
    code = list_folder(context, series, folder, path);
    free(folder);
    return code;
}

/* ---- series --------------------------------------------------------------------------- */

static int same_series(const cvol_dicom_head *a, const cvol_dicom_head *b)
{
    return !strcmp(a->series_uid, b->series_uid) && !strcmp(a->series_number, b->series_number);
}

/* The first head of each series, and its frames; 1 if the head begins a new series. */
static int begins_series(const cvol_dicom_series *s, size_t i, uint64_t *frames)
{
    for (size_t j = 0; j < i; j++)
        if (same_series(&s->heads[j], &s->heads[i]))
            return 0;
    *frames = 0;
    for (size_t j = i; j < s->head_count; j++)
        if (same_series(&s->heads[j], &s->heads[i]))
            *frames += s->heads[j].frames;
    return 1;
}

/* The name that chooses a series: its number, unless another has the same, else its UID. */
static const char *key_of(const cvol_dicom_series *s, size_t i)
{
    const cvol_dicom_head *head = &s->heads[i];
    int unique = head->series_number[0] != '\0';
    for (size_t j = 0; unique && j < s->head_count; j++)
        unique = same_series(head, &s->heads[j]) ||
                 strcmp(head->series_number, s->heads[j].series_number) != 0;
    return unique ? head->series_number : head->series_uid;
}

int cvol_dicom_series_next(const cvol_dicom_series *series, size_t *at, cvol_dicom_summary *out)
{
    while (*at < series->head_count && !begins_series(series, *at, &out->frames))
        ++*at;
    if (*at == series->head_count)
        return 0;
    out->key = key_of(series, *at);
    out->description = series->heads[*at].description;
    ++*at;
    return 1;
}

static int fail_listing(cvol_context *context, const cvol_dicom_series *s, const char *path,
                        const char *asked)
{
    char list[600] = "";
    size_t count = 0, at = 0;
    cvol_dicom_summary one;
    for (size_t i = 0; cvol_dicom_series_next(s, &i, &one);)
        if (count++ < 6 && at < sizeof list - 1)
            at += (size_t)snprintf(list + at, sizeof list - at, "%s'%.60s' (%.30s%s%llu slices)",
                                   count > 1 ? ", " : "", one.key, one.description,
                                   one.description[0] ? ", " : "", (unsigned long long)one.frames);
    return cvol_fail(context, CVOL_ERROR_ARGUMENT,
                     "%s: has %zu series%s%.60s%s; choose one with "
                     "--series: %s%s",
                     path, count, asked ? ", but '" : "", asked ? asked : "",
                     asked ? "' matches none or several" : "", list, count > 6 ? ", ..." : "");
}

/* The first head of the requested series. */
static int find_series(cvol_context *context, const cvol_dicom_series *s, const char *path,
                       size_t first, const char *asked, size_t *out)
{
    size_t found = 0;
    uint64_t frames;
    *out = first;
    for (size_t i = 0; i < s->head_count; i++) {
        const cvol_dicom_head *head = &s->heads[i];
        if (!begins_series(s, i, &frames))
            continue;
        if (asked && strcmp(asked, head->series_number) && strcmp(asked, head->series_uid) &&
            strcmp(asked, head->description))
            continue;
        if (asked || first == SIZE_MAX)
            *out = i;
        found++;
    }
    if (!s->head_count)
        return cvol_fail(context, CVOL_ERROR_FORMAT, "%s: holds no DICOM file with an image", path);
    if (found != 1 && (asked || first == SIZE_MAX))
        return fail_listing(context, s, path, asked);
    return CVOL_OK;
}

/* ---- slices --------------------------------------------------------------------------- */

static int check_same(cvol_context *context, const cvol_dicom_head *a, const cvol_dicom_head *b)
{
    double turned = 0;
    for (int i = 0; i < 6; i++)
        turned = fmax(turned, fabs(a->orientation[i] - b->orientation[i]));
    if (a->has_orientation != b->has_orientation || turned > 1e-3)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its slice is turned against that of %s, of the same series", b->path,
                         cvol_input_name(a->path));
    if (a->rows == b->rows && a->columns == b->columns && a->samples == b->samples &&
        a->allocated == b->allocated && a->is_signed == b->is_signed &&
        fabs(a->spacing[0] - b->spacing[0]) <= 1e-3 * a->spacing[0] &&
        fabs(a->spacing[1] - b->spacing[1]) <= 1e-3 * a->spacing[1])
        return CVOL_OK;
    return cvol_fail(
        context, CVOL_ERROR_FORMAT,
        "%s: has %u x %u pixels of %u bits, %g x %g apart; %s, of the same series, has "
        "%u x %u of %u, %g x %g",
        b->path, b->columns, b->rows, b->allocated, b->spacing[1], b->spacing[0],
        cvol_input_name(a->path), a->columns, a->rows, a->allocated, a->spacing[1], a->spacing[0]);
}

static void normal_of(double out[3], const double o[6])
{
    for (int i = 0; i < 3; i++)
        out[i] = o[(i + 1) % 3] * o[3 + (i + 2) % 3] - o[(i + 2) % 3] * o[3 + (i + 1) % 3];
}

static const cvol_dicom_frame *frame_of(const cvol_dicom_series *s, const cvol_dicom_slice *slice)
{
    return &s->heads[slice->head].frame[slice->frame];
}

static int collect_slices(cvol_context *context, cvol_dicom_series *s, size_t chosen,
                          int *has_positions)
{
    const cvol_dicom_head *model = &s->heads[chosen];
    double normal[3];
    uint64_t frames = 0;
    normal_of(normal, model->orientation);
    *has_positions = model->has_orientation;
    for (size_t i = 0; i < s->head_count; i++)
        frames += same_series(model, &s->heads[i]) ? s->heads[i].frames : 0;
    s->slices = malloc((size_t)frames * sizeof *s->slices);
    if (!s->slices)
        return cvol_fail_memory(context, (size_t)frames * sizeof *s->slices, model->path);
    for (size_t i = 0; i < s->head_count; i++) {
        const cvol_dicom_head *head = &s->heads[i];
        if (!same_series(model, head))
            continue;
        int code = check_same(context, model, head);
        if (code)
            return code;
        for (uint64_t f = 0; f < head->frames; f++) {
            const double *p = head->frame[f].position;
            s->slices[s->count++] = (cvol_dicom_slice){
                i, f, p[0] * normal[0] + p[1] * normal[1] + p[2] * normal[2]};
            *has_positions = *has_positions && head->frame[f].has_position;
        }
    }
    return CVOL_OK;
}

/* Two slices closer than this have the same position. */
static double same_place(const cvol_dicom_series *s)
{
    const double *spacing = s->heads[s->slices[0].head].spacing;
    return 0.01 * (spacing[0] > 0 ? spacing[0] : 1);
}

static int compare_times(const void *a, const void *b, void *user)
{
    const cvol_dicom_series *s = user;
    const cvol_dicom_slice *p = a, *q = b;
    const cvol_dicom_head *h = &s->heads[p->head], *k = &s->heads[q->head];
    if (h->time < k->time || h->time > k->time)
        return h->time < k->time ? -1 : 1;
    if (h->instance < k->instance || h->instance > k->instance)
        return h->instance < k->instance ? -1 : 1;
    if (p->head != q->head) /* natural order of names; paths of one folder begin differently */
        return cvol_folder_compare(cvol_input_name(h->path), cvol_input_name(k->path));
    return p->frame < q->frame ? -1 : p->frame > q->frame;
}

static int compare_places(const void *a, const void *b, void *user)
{
    const cvol_dicom_slice *p = a, *q = b;
    if (p->along < q->along || p->along > q->along)
        return p->along < q->along ? -1 : 1;
    return compare_times(a, b, user);
}

/* The number of slices at the position of slice `at`; sorts these by time. */
static size_t sort_place(cvol_dicom_series *s, size_t at)
{
    size_t end = at + 1;
    while (end < s->count && s->slices[end].along - s->slices[at].along < same_place(s))
        end++;
    qsort_r(s->slices + at, end - at, sizeof *s->slices, compare_times, s);
    return end - at;
}

/* Keeps one slice of each position. */
static int choose_time(cvol_context *context, cvol_dicom_series *s, const char *path,
                       const cvol_read_options *options)
{
    size_t times = sort_place(s, 0), kept = 0, time;
    for (size_t at = 0, here; at < s->count; at += here) {
        here = sort_place(s, at);
        if (here != times)
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: slices are missing or repeated: %zu are at the position of %s, "
                             "but %zu at that of %s",
                             path, times, cvol_input_name(s->heads[s->slices[0].head].path), here,
                             cvol_input_name(s->heads[s->slices[at].head].path));
    }
    int code = cvol_format_choose(context, &time, path, "volume", "--time", times,
                                  options->has_index, options->index);
    for (size_t at = 0; !code && at < s->count; at += times)
        s->slices[kept++] = s->slices[at + time];
    s->count = kept;
    return code;
}

int cvol_dicom_series_choose(cvol_context *context, cvol_dicom_series *series, const char *path,
                             size_t first, const cvol_read_options *options)
{
    size_t chosen;
    int has_positions;
    int code = find_series(context, series, path, first, options->series, &chosen);
    if (!code)
        code = collect_slices(context, series, chosen, &has_positions);
    if (code)
        return code;
    if (has_positions) {
        qsort_r(series->slices, series->count, sizeof *series->slices, compare_places, series);
        return choose_time(context, series, path, options);
    }
    qsort_r(series->slices, series->count, sizeof *series->slices, compare_times, series);
    for (size_t i = 0; i < series->count; i++)
        series->slices[i].along = NAN;
    return CVOL_OK;
}

/* ---- offsets -------------------------------------------------------------------------- */

static int compare_numbers(const void *a, const void *b)
{
    const double *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

/* The median of the slices' distances. */
static int median_gap(cvol_context *context, const cvol_dicom_series *s, double *out)
{
    size_t count = s->count - 1;
    double *gaps = malloc(count * sizeof *gaps);
    if (!gaps)
        return cvol_fail_memory(context, count * sizeof *gaps, "distances of slices");
    for (size_t i = 0; i < count; i++)
        gaps[i] = s->slices[i + 1].along - s->slices[i].along;
    qsort(gaps, count, sizeof *gaps, compare_numbers);
    *out = gaps[(count - 1) / 2];
    free(gaps);
    return CVOL_OK;
}

/* Distances may differ by a twentieth, since positions are rounded. */
static int check_even(cvol_context *context, const cvol_dicom_series *s, const char *path)
{
    double gap = 1, missing = 0, least = INFINITY, most = 0;
    size_t widest = 0;
    int whole = 1, code = median_gap(context, s, &gap);
    if (code)
        return code;
    for (size_t i = 0; i + 1 < s->count; i++) {
        double here = s->slices[i + 1].along - s->slices[i].along, steps = round(here / gap);
        whole = whole && steps >= 1 && fabs(here - steps * gap) <= 0.05 * gap * steps;
        missing += steps - 1;
        widest = here > most ? i : widest;
        least = fmin(least, here);
        most = fmax(most, here);
    }
    if (whole && missing < 0.5)
        return CVOL_OK;
    const char *after = cvol_input_name(s->heads[s->slices[widest].head].path);
    if (whole)
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: slices are missing, %.0f as it seems: behind %s the next one is %g "
                         "mm away, others are %g; --spacing SX,SY,SZ reads them as evenly spaced",
                         path, missing, after, most, gap);
    return cvol_fail(
        context, CVOL_ERROR_FORMAT,
        "%s: its slices are not evenly spaced, from %g to %g mm (behind %s); --spacing "
        "SX,SY,SZ reads them as if they were",
        path, least, most, after);
}

/* The third axis runs from the first slice to the last one, which need not be along the normal. */
static int place_slices(cvol_context *context, const cvol_dicom_series *s, cvol_grid *grid,
                        const char *path, int asked)
{
    const double *first = frame_of(s, &s->slices[0])->position;
    const double *last = frame_of(s, &s->slices[s->count - 1])->position;
    double step[3], aside = 0;
    int code = asked ? CVOL_OK : check_even(context, s, path);
    for (int i = 0; i < 3; i++)
        step[i] = (last[i] - first[i]) / (double)(s->count - 1);
    if (code || !cvol_geometry_set_axis(grid, 2, step))
        return code;
    for (size_t z = 0; z < s->count && !asked; z++)
        for (int i = 0; i < 3; i++)
            aside = fmax(aside, fabs(frame_of(s, &s->slices[z])->position[i] - first[i] -
                                     (double)z * step[i]));
    if (aside > 0.1 * grid->spacing[2] + same_place(s))
        return cvol_fail(context, CVOL_ERROR_FORMAT,
                         "%s: its slices do not lie on a line at equal distances: one is %g mm off",
                         path, aside);
    return CVOL_OK;
}

static void set_values(cvol_dicom_series *s, cvol_grid *grid)
{
    const cvol_dicom_frame *first = frame_of(s, &s->slices[0]);
    for (size_t z = 1; z < s->count; z++) {
        const cvol_dicom_frame *frame = frame_of(s, &s->slices[z]);
        if (frame->slope < first->slope || frame->slope > first->slope ||
            frame->intercept < first->intercept || frame->intercept > first->intercept)
            s->varies = 1;
    }
    if (s->varies) {
        grid->type = CVOL_FLOAT32;
        return;
    }
    grid->value_scale = first->slope;
    grid->value_offset = first->intercept;
}

int cvol_dicom_series_place(cvol_context *context, cvol_dicom_series *series, cvol_grid *grid,
                            const char *path, const cvol_read_options *options)
{
    const cvol_dicom_head *head = &series->heads[series->slices[0].head];
    const int asked = options->spacing[2] > 0;
    int known[3] = {1, 1, 0};
    snprintf(grid->unit, sizeof grid->unit, "mm");
    grid->space = CVOL_SPACE_LPS;
    set_values(series, grid);
    for (int a = 0; a < 2 && head->has_orientation; a++)
        if (!cvol_geometry_set_axis(grid, a, head->orientation + (ptrdiff_t)(3 * a)))
            return cvol_fail(context, CVOL_ERROR_FORMAT,
                             "%s: ImageOrientationPatient is (%g, %g, %g, %g, %g, %g)", head->path,
                             head->orientation[0], head->orientation[1], head->orientation[2],
                             head->orientation[3], head->orientation[4], head->orientation[5]);
    /* The distance of rows comes first: the spacing along y. */
    grid->spacing[0] = head->spacing[1] != 0 ? head->spacing[1] : 1;
    grid->spacing[1] = head->spacing[0] != 0 ? head->spacing[0] : grid->spacing[0];
    grid->spacing[2] = head->between > 0     ? head->between
                       : head->thickness > 0 ? head->thickness
                                             : 1;
    if (head->has_orientation)
        cvol_geometry_complete(grid, known);
    const cvol_dicom_frame *first = frame_of(series, &series->slices[0]);
    if (first->has_position)
        memcpy(grid->origin, first->position, sizeof grid->origin);
    int code = CVOL_OK;
    if (series->count > 1 && isfinite(series->slices[0].along))
        code = place_slices(context, series, grid, path, asked);
    return code ? code : cvol_geometry_check(context, grid, path);
}
