/* Lists of directions: a file of rotations or angles, one a line. */
#ifndef CVOL_TOOLS_POSES_H
#define CVOL_TOOLS_POSES_H

#include "cli.h"

typedef struct pose {
    int line;          /* of the file, from 1 on */
    double numbers[4]; /* w x y z, or azimuth, elevation and roll in degrees */
} pose;

typedef struct pose_list {
    pose *poses;
    size_t count;
    int numbers; /* of each: 4 or 3 */
} pose_list;

/* Numbers between commas, semicolons or blanks; empty lines, what follows a '#', and a first line
 * of names are passed over. Exit status, after a sentence that names file, line and value. */
int read_poses(pose_list *out, const char *path);
void free_poses(pose_list *list);

#endif
