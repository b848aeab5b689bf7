/* cvol compress of several volumes into one file, each as if compressed alone. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tools/compress/compress.h"
#include "tools/labels/labels.h"

/* The series in progress, and its results so far. */
typedef struct series_job {
    cvol_context *context;
    compress_arguments *a;
    const method *m;
    const volume_list *inputs;
    const char *out_path;
    int times, channels, times_inside, channels_inside; /* total; in each file */
    int by_channel;                                     /* --as channels */
    volume_labels stored;
    cvol_series_options options;
    cvol_series_writer *writer;
    cvol_type first_type; /* of the first volume; 0: not known yet */
    int types_differ;     /* 64-bit integers became several types: they must all be float64 */
    double least_psnr, most_psnr, max_error, raw_bytes;
    uint64_t file_bytes;
    int missed;  /* number of targets missed by too large volumes, */
    int finest;  /* and by volumes that are smaller even with the finest step */
    int yielded; /* number of volumes where a PSNR replaced the default ratio */
    int labels;  /* number of label volumes, which are lossless */
    json_t *volumes;
} series_job;

/* ---- arguments ---------------------------------------------------------------------- */

static int count_all(series_job *job)
{
    const volume_list *inputs = job->inputs;
    const char *as = job->a->as ? job->a->as : "times";
    if (parse_word(&job->by_channel, &as_words, "--as", as))
        return EXIT_MISUSED;
    for (int i = 0; i < inputs->count; i++) {
        int times, channels;
        const int status = count_volumes(job->context, &job->a->common, inputs->paths[i], &times,
                                         &channels);
        if (status)
            return status;
        if (!i) {
            job->times_inside = times;
            job->channels_inside = channels;
        } else if (times != job->times_inside || channels != job->channels_inside)
            return report_error(
                EXIT_FAILED,
                "%s: has %d times and %d channels, but %s has %d and %d; they must be the "
                "same in one series",
                inputs->paths[i], times, channels, inputs->paths[0], job->times_inside,
                job->channels_inside);
    }
    const int several = job->by_channel ? job->channels_inside : job->times_inside;
    if (inputs->count > 1 && several > 1)
        return report_error(
            EXIT_MISUSED,
            "%s: has %d %s; with several files each must have one: choose it with --%s",
            inputs->paths[0], several, job->by_channel ? "channels" : "times",
            job->by_channel ? "channel" : "time");
    job->times = inputs->count > 1 && !job->by_channel ? inputs->count : job->times_inside;
    job->channels = inputs->count > 1 && job->by_channel ? inputs->count : job->channels_inside;
    return EXIT_DONE;
}

static int has_series_options(const compress_arguments *a)
{
    return a->time_step_given || a->channel_names || a->channel_colours || a->as;
}

/* Splits a text at commas; the caller frees *out and *copy. */
static int split_names(const char ***out, char **copy, const char *text, int count)
{
    int found = 0;
    *copy = strdup(text);
    *out = calloc((size_t)count, sizeof **out);
    if (!*copy || !*out)
        return report_error(EXIT_FAILED, "not enough memory");
    for (char *next = *copy; next; found++) {
        char *comma = strchr(next, ',');
        if (comma)
            *comma = '\0';
        if (found < count)
            (*out)[found] = next;
        next = comma ? comma + 1 : NULL;
    }
    return found == count
               ? EXIT_DONE
               : report_error(EXIT_MISUSED, "--channel-names is '%s', must have %d names", text,
                              count);
}

/* ---- a volume ------------------------------------------------------------------------------- */

static void add_report(series_job *job, const char *path, const cvol_grid *grid,
                       const cvol_compress_report *report, int has_yielded)
{
    const double raw_bytes = (double)cvol_grid_bytes(grid);
    job->least_psnr = fmin(job->least_psnr, report->psnr_db);
    job->most_psnr = fmax(job->most_psnr, report->psnr_db);
    job->max_error = fmax(job->max_error, report->max_error);
    job->raw_bytes += raw_bytes;
    job->yielded += has_yielded;
    const int is_missed = !report->target_met && !report->lossless;
    const int is_finest = is_missed && size_wanted(job->m, grid, report) >= 1;
    job->finest += is_finest;
    job->missed += is_missed && !is_finest;
    if (job->volumes)
        json_array_append_new(job->volumes,
                              json_pack("{s:o, s:I, s:f, s:o, s:b, s:f, s:b, s:b, s:b}", "input",
                                        json_text(path), "bytes", (json_int_t)report->file_bytes,
                                        "ratio", raw_bytes / (double)report->file_bytes, "psnr_db",
                                        json_decibels(report->psnr_db), "exact",
                                        is_exact(report->psnr_db), "max_error", report->max_error,
                                        "lossless", report->lossless, "target_met",
                                        report->target_met, "yielded_to_psnr", has_yielded));
}

/* 1 if a volume has another type than the first one, and both may come from 64-bit integers, which
 * become the narrowest type that holds those of a volume. */
static int has_other_type(series_job *job, cvol_type type)
{
    const cvol_type first = job->first_type ? job->first_type : type;
    const cvol_type types[] = {first, type};
    job->first_type = first;
    job->types_differ = type != first && !job->a->common.read.wide_float64;
    for (int i = 0; i < 2; i++)
        job->types_differ &= types[i] == CVOL_INT32 || types[i] == CVOL_UINT32 ||
                             types[i] == CVOL_FLOAT64;
    return job->types_differ;
}

static int add_slabs(series_job *job, compress_arguments *a, slab_input *in, const char *path)
{
    const input none = {0};
    cvol_compress_report report = {0};
    cvol_compress_options options = job->m->options;
    char *attributes = NULL;
    const cvol_grid grid = *slab_input_grid(in);
    if (has_other_type(job, grid.type))
        return EXIT_FAILED;
    int status = check_slab_labels(job->context, a, path, grid.type);
    if (!status)
        status = find_attributes(&attributes, &none, a->attributes);
    if (!status)
        status = add_label_attributes(&attributes, a->label_file, path);
    options.attributes = attributes;
    int code = status ? 0 : add_slabs_to(job->context, job->writer, in, &report, &options);
    if (code && yields_to_psnr(a, &options, code, &report))
        code = add_slabs_to(job->context, job->writer, in, &report, &options);
    free(attributes);
    if (code)
        return report_compression_error(job->context, code, path, &options, &report);
    if (!status)
        add_report(job, path, &grid, &report, a->has_yielded);
    return status;
}

static int add_array(series_job *job, compress_arguments *a, const char *path)
{
    cvol_array *array;
    cvol_compress_report report = {0};
    compress_arguments own = *a;
    int status = compress_to_array(job->context, &own, job->m, path, &array, &report);
    a->was_compressed = own.was_compressed;
    int code;
    if (!status && has_other_type(job, cvol_array_grid(array)->type))
        status = EXIT_FAILED;
    if (!status && (code = cvol_series_add(job->context, job->writer, array, &report.file_bytes)))
        status = report_context_error(job->context, code, path);
    if (!status && job->m->truncate)
        fill_report(&report, array);
    if (!status)
        add_report(job, path, cvol_array_grid(array), &report, own.has_yielded);
    job->labels += !status && own.has_labels;
    cvol_array_free(array);
    return status;
}

static int add_volume(series_job *job, int time, int channel)
{
    compress_arguments a = *job->a;
    a.is_one_of_many = 1;
    cvol_read_options *read = &a.common.read;
    const int file = job->inputs->count == 1 ? 0 : job->by_channel ? channel : time;
    const char *path = job->inputs->paths[file];
    slab_input in = {0};
    if (job->times_inside > 1) {
        read->has_index = 1;
        read->index = time;
    }
    if (job->channels_inside > 1) {
        read->has_channel = 1;
        read->channel = channel;
    }
    int status = EXIT_DONE;
    if (!option_against_streams(&a, job->m) && !is_cvol(path))
        status = open_slab_input(job->context, &in, path, &a.common, a.stream);
    if (!status)
        status = in.stream ? add_slabs(job, &a, &in, path) : add_array(job, &a, path);
    close_slab_input(&in);
    return status;
}

static int add_all(series_job *job)
{
    int status = EXIT_DONE;
    const int count = job->times * job->channels;
    for (int i = 0; i < count && !status; i++) {
        char what[64];
        snprintf(what, sizeof what, "volume %d of %d", i + 1, count);
        override_progress(what, (double)i / count);
        status = add_volume(job, i / job->channels, i % job->channels);
        if (!status && was_interrupted())
            status = report_error(EXIT_FAILED, "cancelled");
    }
    override_progress(NULL, 0);
    return status;
}

/* ---- the file ------------------------------------------------------------------------------- */

static int report_json(const series_job *job)
{
    return print_json(json_pack(
        "{s:i, s:i, s:I, s:f, s:o, s:b, s:f, s:O}", "times", job->times, "channels", job->channels,
        "file_bytes", (json_int_t)job->file_bytes, "ratio",
        job->raw_bytes / (double)job->file_bytes, "psnr_db", json_decibels(job->least_psnr),
        "exact", is_exact(job->least_psnr), "max_error", job->max_error, "volumes", job->volumes));
}

static void report_text(const series_job *job)
{
    clear_progress();
    printf("%s: ", job->out_path);
    if (job->times > 1)
        printf("%d times%s", job->times, job->channels > 1 ? " of " : ", ");
    if (job->channels > 1)
        printf("%d channels, ", job->channels);
    char share[SHARE_TEXT];
    printf("%llu bytes, %s, ", (unsigned long long)job->file_bytes,
           share_text(share, job->raw_bytes / (double)job->file_bytes));
    if (isinf(job->least_psnr))
        printf("exact\n");
    else if (isinf(job->most_psnr))
        printf("PSNR %.2f dB and more, largest error %g\n", job->least_psnr, job->max_error);
    else
        printf("PSNR %.2f to %.2f dB, largest error %g\n", job->least_psnr, job->most_psnr,
               job->max_error);
    if (job->labels)
        printf(
            "(%d of %d volumes are labels: compressed without loss; give --labels no or a target, "
            "as in --ratio 30, for lossy compression)\n",
            job->labels, job->times * job->channels);
    if (job->yielded)
        printf("(%d of %d volumes: ratio %g would give a PSNR below %d dB; compressed to %d dB "
               "instead; "
               "--force: keep to the ratio)\n",
               job->yielded, job->times * job->channels, job->a->ratio, LEAST_PSNR, PSNR_INSTEAD);
    if (job->missed)
        printf("(%d volumes: the target is out of reach; they are as small as possible)\n",
               job->missed);
    if (job->finest)
        printf("(%d volumes: the target is out of reach; their finest lossy files are smaller)\n",
               job->finest);
}

static int write_series(series_job *job)
{
    const series_job unwritten = *job;
    int code = cvol_series_writer_open(job->context, &job->writer, job->out_path, &job->options);
    if (code)
        return report_context_error(job->context, code, NULL);
    int status = add_all(job);
    if (status)
        cvol_series_writer_abandon(job->writer);
    if (status && job->types_differ) { /* again, as one type */
        *job = unwritten;
        json_array_clear(job->volumes);
        job->a->common.read.wide_float64 = 1;
        return write_series(job);
    }
    if (status)
        return status;
    code = cvol_series_writer_commit(job->context, job->writer, &job->file_bytes);
    if (code)
        return report_context_error(job->context, code, NULL);
    if (job->a->common.json)
        return report_json(job);
    report_text(job);
    return EXIT_DONE;
}

/* Finds names and times: of one file all of them; with --as channels the name of each file, and the
 * times of the first one; of files that are times the channels of the first one. Files do not know
 * their distance in time. */
static int find_stored_labels(series_job *job)
{
    const volume_list *inputs = job->inputs;
    common_options *common = &job->a->common;
    if (!job->by_channel || inputs->count == 1)
        return find_labels(job->context, &job->stored, common, inputs->paths[0], job->times_inside,
                           job->channels_inside);
    job->stored.channels = job->channels;
    job->stored.names = calloc((size_t)job->channels, sizeof *job->stored.names);
    int status = job->stored.names ? EXIT_DONE : report_error(EXIT_FAILED, "not enough memory");
    for (int c = 0; c < job->channels && !status; c++) {
        volume_labels one;
        status = find_labels(job->context, &one, common, inputs->paths[c], job->times_inside, 1);
        if (!status) {
            job->stored.names[c] = one.names[0];
            one.names[0] = NULL;
        }
        if (!status && c == 0) {
            job->stored.times = one.times;
            job->stored.unit = one.unit;
            one.times = NULL;
            one.unit = NULL;
        }
        free_labels(&one);
    }
    return status;
}

/* Sets times, names and colours, from the options or else from the files; then writes the series.
 */
static int describe_and_write(series_job *job)
{
    const compress_arguments *a = job->a;
    const char **names = NULL;
    const volume_labels *stored = &job->stored;
    char *names_text = NULL;
    double *times = calloc((size_t)job->times, sizeof *times);
    double *colours = calloc(3 * (size_t)job->channels, sizeof *colours);
    int status = times && colours ? EXIT_DONE : report_error(EXIT_FAILED, "not enough memory");
    job->options = (cvol_series_options){
        .size = sizeof(cvol_series_options), .times = job->times, .channels = job->channels};
    if (!status)
        status = find_stored_labels(job);
    if (!status && stored->are_colours && job->a->labels == LABELS_AUTO)
        job->a->labels = LABELS_NO; /* few levels of red are no labels */
    if (!status && stored->times && job->times == job->times_inside) {
        job->options.time_values = stored->times;
        job->options.time_unit = stored->unit;
    }
    for (int t = 0; !status && a->time_step_given && t < job->times; t++)
        times[t] = t * a->time_step;
    if (a->time_step_given) {
        job->options.time_values = times;
        job->options.time_unit = "s";
    }
    if (!status && a->channel_names)
        status = split_names(&names, &names_text, a->channel_names, job->channels);
    job->options.channel_names = names ? names : (const char *const *)stored->names;
    job->options.channel_colours = stored->colours;
    job->options.colours = stored->are_colours && job->channels == job->channels_inside &&
                           !a->channel_colours && !a->channel_names;
    if (!status && a->channel_colours) {
        status = parse_colours(colours, job->channels, a->channel_colours);
        job->options.channel_colours = colours;
    }
    if (!status)
        status = write_series(job);
    free(names);
    free(names_text);
    free(times);
    free(colours);
    free_labels(&job->stored);
    return status;
}

int compress_series(cvol_context *context, compress_arguments *a, const method *m,
                    const volume_list *inputs, int *many)
{
    series_job job = {.context = context,
                      .a = a,
                      .m = m,
                      .inputs = inputs,
                      .out_path = a->output,
                      .least_psnr = (double)INFINITY,
                      .most_psnr = -(double)INFINITY};
    int status = count_all(&job);
    if (status)
        return status;
    *many = job.times > 1 || job.channels > 1;
    if (!*many)
        return has_series_options(a)
                   ? report_error(EXIT_MISUSED,
                                  "%s: is one volume: leave out --as, --time-step, "
                                  "--channel-names and --channel-colors",
                                  inputs->paths[0])
                   : EXIT_DONE;
    if ((int64_t)job.times * job.channels > CVOL_SERIES_MOST)
        return report_error(EXIT_FAILED, "%s: %d times and %d channels are more than %d volumes",
                            inputs->paths[0], job.times, job.channels, (int)CVOL_SERIES_MOST);
    if (compressor_of_streams != cvol_compress_stream)
        return report_error(EXIT_MISUSED,
                            "%s: has %d times and %d channels; cvol-mpi compresses one volume: use "
                            "cvol compress",
                            inputs->paths[0], job.times, job.channels);
    status = check_stream(a, m);
    for (int i = 0; i < inputs->count && !status; i++)
        status = check_output(inputs->paths[i], a->output);
    job.volumes = !status && a->common.json ? json_array() : NULL;
    if (!status)
        status = describe_and_write(&job);
    json_decref(job.volumes);
    return status;
}
