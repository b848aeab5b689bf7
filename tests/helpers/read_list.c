/* read_list: reads lines of standard input, each
 *     FILE REFERENCE SX,SY,SZ[,UNIT] [channel=I] [index=I] [series=NAME] [spacing=SX,SY,SZ]
 * and checks that FILE, read with these choices, has REFERENCE's shape, type and samples, and this
 * spacing; also slice by slice from the last to the first. Prints the number of valid lines, and
 * all errors. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cvol/cvol.h"

static int complain(const char *file, const char *what)
{
    printf("%s: %s\n", file, what);
    return 0;
}

static int set_option(cvol_read_options *options, char *word)
{
    double *s = options->spacing;
    if (sscanf(word, "channel=%d", &options->channel) == 1)
        options->has_channel = 1;
    else if (sscanf(word, "index=%d", &options->index) == 1)
        options->has_index = 1;
    else if (!strncmp(word, "series=", 7))
        options->series = word + 7;
    else
        return sscanf(word, "spacing=%lf,%lf,%lf", &s[0], &s[1], &s[2]) == 3;
    return 1;
}

/* The last slice first: readers may not rely on order. */
static int check_slices(cvol_context *context, const char *file, const cvol_read_options *options,
                        const cvol_volume *whole)
{
    cvol_volume_stream *stream;
    if (cvol_volume_stream_open(context, &stream, file, options))
        return complain(file, cvol_context_message(context));
    const size_t sheets = whole->grid.dims[2], bytes = cvol_grid_bytes(&whole->grid) / sheets;
    void *sheet = malloc(bytes);
    int same = sheet != NULL;
    for (size_t z = sheets; same && z-- > 0;)
        same = !cvol_volume_stream_read(context, stream, sheet, z, 1) &&
               !memcmp(sheet, (const char *)whole->data + z * bytes, bytes);
    free(sheet);
    cvol_volume_stream_free(stream);
    return same || complain(file, "its sheets are not the whole volume's");
}

static int check_same(const char *file, const cvol_volume *a, const cvol_volume *b,
                      const char *spacing)
{
    char unit[16] = "";
    double s[3];
    for (int i = 0; i < 3; i++)
        if (a->grid.dims[i] != b->grid.dims[i])
            return complain(file, "has another shape");
    if (a->grid.type != b->grid.type)
        return complain(file, "has another type");
    if (memcmp(a->data, b->data, cvol_grid_bytes(&a->grid)))
        return complain(file, "has other samples");
    if (sscanf(spacing, "%lf,%lf,%lf,%15s", &s[0], &s[1], &s[2], unit) < 3)
        return complain(file, "the line has no spacing");
    for (int i = 0; i < 3; i++)
        if (!(fabs(a->grid.spacing[i] - s[i]) <= 1e-5 * s[i]))
            return complain(file, "has another spacing");
    return !unit[0] || !strcmp(unit, a->grid.unit) || complain(file, "has another unit");
}

static int check_line(cvol_context *context, char *line)
{
    const char *file = strtok(line, " \n"), *reference = strtok(NULL, " \n");
    const char *spacing = strtok(NULL, " \n");
    cvol_read_options options = cvol_read_options_defaults();
    if (!file || !reference || !spacing)
        return complain(file ? file : "?", "the line is too short");
    for (char *word; (word = strtok(NULL, " \n"));)
        if (!set_option(&options, word))
            return complain(file, "the line has an option that is none");
    cvol_volume *a = NULL, *b = NULL;
    int sound = !cvol_volume_read(context, &a, file, &options) &&
                !cvol_volume_read(context, &b, reference, NULL);
    if (!sound)
        complain(file, cvol_context_message(context));
    sound = sound && check_same(file, a, b, spacing) && check_slices(context, file, &options, a);
    cvol_volume_free(a);
    cvol_volume_free(b);
    return sound;
}

int main(void)
{
    char line[1024];
    int held = 0, failed = 0;
    cvol_context *context = cvol_context_create();
    while (context && fgets(line, sizeof line, stdin))
        if (check_line(context, line))
            held++;
        else
            failed++;
    printf("%d files held, %d did not\n", held, failed);
    cvol_context_free(context);
    return failed || !held;
}
