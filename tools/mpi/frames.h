/* The stages and messages of each picture that several processes draw, for --json. */
#ifndef CVOL_TOOLS_MPI_FRAMES_H
#define CVOL_TOOLS_MPI_FRAMES_H

#include <jansson.h>

#include "cvol/mpi.h"

/* Notes a picture; read_s: the longest time of a process to read its part, 0: it had it already. */
void note_frame(const cvol_mpi_render_report *report, double read_s);
/* Takes the list of all pictures noted since the last call; NULL: none, or no memory. */
json_t *take_frames(void);

#endif
