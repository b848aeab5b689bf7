/* The volumes that cvol view and cvol export show. */
#ifndef CVOL_TOOLS_VIEW_LIST_H
#define CVOL_TOOLS_VIEW_LIST_H

#include "tools/base/cli.h"
#include "tools/labels/labels.h"
#include "viewer/base/options.h"

typedef struct view_list {
    viewer_volume *volumes;
    int count;
    char **names;         /* [count]; NULL: that of the file */
    volume_labels *named; /* [named_count]: times of files of several */
    int named_count;
    label_table *tables;   /* [count]: of the volumes' files */
    viewer_label **labels; /* [count] */
} view_list;

/* label_file: --label-table, or NULL. Lists the volumes of the files, after it checked that a
 * reader knows them: those that the options choose, or all. Each channel of a file, at most
 * VIEWS_MOST, is a volume with all its times. The caller frees *out, after a failure too. Exit
 * status. */
enum { VIEWS_MOST = 32 };
int list_views(cvol_context *context, view_list *out, const common_options *common,
               const char *label_file, const char **paths, int count);
void free_views(view_list *list);

#endif
