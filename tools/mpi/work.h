/* What the processes divide: each function makes the commands of tools/ do their work together. */
#ifndef CVOL_TOOLS_MPI_WORK_H
#define CVOL_TOOLS_MPI_WORK_H

/* Pictures of cvol render. */
void divide_drawing(void);
void free_drawing(void);
/* Layers of bricks of cvol compress --stream. */
void divide_compression(void);
/* Blocks of one volume, for the commands that compute on .cvol files. */
void divide_computing(void);
/* The same for commands that need all blocks of their operands. */
void divide_whole_operands(void);

/* Runs cvol view: process 0 serves the page, all draw. Exit status. */
int view_together(int argc, char **argv);

#endif
