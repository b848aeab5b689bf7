/* Lists of camera poses: a text file with a rotation or three angles on each line. */
#ifndef CVOL_TOOLS_POSES_H
#define CVOL_TOOLS_POSES_H

#include "tools/base/cli.h"

typedef struct pose {
    int line;          /* line number in the file, from 1 */
    double numbers[4]; /* w x y z, or azimuth, elevation and roll in degrees */
} pose;

typedef struct pose_list {
    pose *poses;
    size_t count;
    int numbers; /* of each: 4 or 3 */
} pose_list;

/* Reads numbers separated by commas, semicolons or blanks. Skips empty lines, text after '#', and a
 * first line of column names. Exit status, after a message that names file, line and value. */
int read_poses(pose_list *out, const char *path);
void free_poses(pose_list *list);

#endif
