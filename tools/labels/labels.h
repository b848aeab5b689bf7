/* Labels: numbers of regions, with their names and colours. */
#ifndef CVOL_TOOLS_LABELS_H
#define CVOL_TOOLS_LABELS_H

#include "tools/base/cli.h"

enum { LABEL_NAME = 64, LABELS_DRAWN_MAX = 255, LABELS_MOST = 65536 };

/* Facts about one label. */
typedef struct label_entry {
    int value;
    char name[LABEL_NAME]; /* "": none */
    int has_colour;
    double rgb[3];
} label_entry;

/* By value. */
typedef struct label_table {
    label_entry *entries;
    size_t count;
} label_table;

/* label_table.c: reads the labels of ITK-SNAP, FreeSurfer or 3D Slicer from `file`, or, if it is
 * NULL, those of `path`: the segments in the header of an NRRD file, the attributes of a .cvol
 * file, those of an image of OME-Zarr, or those in NIfTI and MGH; an empty table if there are none.
 * The caller frees *out, after a failure too. Exit status. */
int read_labels(label_table *out, const char *file, const char *path);
void free_labels_table(label_table *table);
/* A new entry, empty; NULL without memory. The caller checks LABELS_MOST. */
label_entry *add_label_entry(label_table *table);
/* label_attributes.c: adds the labels of `file` (--label-table), or (NULL) of the file `path`, to
 * attributes in JSON, which may be NULL; attributes that are no object stay. Exit status. */
int add_label_attributes(char **attributes, const char *file, const char *path);
/* Adds the labels of a .cvol file; none if it is damaged or has none. Exit status. */
int read_label_attributes(label_table *out, const char *path);
/* label_zarr.c: reads the labels of an image of OME-Zarr, or of one of its levels; *found: it is
 * one of labels. Exit status. */
int read_label_zarr(label_table *out, int *found, const char *path);
/* NULL: the table does not have it. */
const label_entry *find_label(const label_table *table, int value);

/* The values of the samples. */
typedef struct label_values {
    int *values; /* rising */
    uint64_t *samples;
    size_t count;
    int background; /* 0, or the commonest value if no sample is 0 */
} label_values;

/* A choice of labels, and the options' names for messages. */
typedef struct label_choice {
    const char *text, *file; /* --labels and --label-table, or NULL */
    const char *option, *file_option;
} label_choice;

/* label_values.c: counts the samples of each value; the caller frees *out, after a failure too.
 * Exit status. */
int count_labels(label_values *out, const cvol_volume *volume, const char *path);
void free_values(label_values *values);
/* 1 if all samples are whole numbers that labels can be: those of int. */
int has_label_range(const cvol_volume *volume);
/* Sample `i` of a volume that count_labels accepts. */
int label_at(const cvol_volume *volume, size_t i);
/* The same for any volume. */
double value_at(const cvol_volume *volume, size_t i);
/* Sets chosen[i] to 1 or 0 for each value; without a text (NULL) all but the background are chosen.
 * Exit status. */
int choose_label_values(uint8_t *chosen, const label_values *values, const label_table *table,
                        const label_choice *choice, const char *path);

/* info_labels.c: *out: 1 if the samples are labels that count_labels accepts, by
 * cvol_volume_is_labels or because they are few whole numbers, as cvol_transfer_create_auto
 * decides. Exit status. */
int find_label_kind(cvol_context *context, int *out, const cvol_volume *volume, const char *path);
/* *out: the labels of an open volume as a JSON array, with names, numbers of samples
 * and volumes; NULL if it has none. file: --label-table, or NULL. Exit status. */
int list_labels_of(cvol_context *context, json_t **out, input *in, const char *file,
                   const char *path);
void print_label_list(const json_t *list, const cvol_grid *grid);
/* Refuses a .cvol file whose samples are not exact, or no whole numbers. Exit status. */
int check_whole_samples(const input *in, const char *path);
/* 1 if it probably holds labels of more than `least` values, by its size. */
int may_be_labels(cvol_context *context, const input *in, int least);

/* label_set.c: sets samples of integers without a value, by the mask of the array of *in, to 0 in
 * its volume: they are no label, whatever their fill. Exit status. */
int clear_missing_labels(input *in);

/* The labels of a picture, whose samples are 1 .. count; 0: others. */
typedef struct label_set {
    label_entry entries[LABELS_DRAWN_MAX];
    size_t count;
} label_set;

/* label_set.c: replaces the samples of a volume by numbers of chosen labels, as uint8. Exit
 * status. */
int number_labels(cvol_context *context, label_set *out, cvol_volume **volume,
                  const label_choice *choice, const char *path);
/* The transfer function of such samples. A code of the library. */
int create_label_transfer(cvol_context *context, cvol_transfer **out, const label_set *set);
json_t *describe_labels(const label_set *set);

#endif
