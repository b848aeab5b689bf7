/* Messages of several processes: process 0 prints one sentence, whichever process failed. */
#ifndef CVOL_TOOLS_MPI_MESSAGES_H
#define CVOL_TOOLS_MPI_MESSAGES_H

#define MESSAGE 1000

/* Makes a process silent: only process 0 writes to the terminal. Returns 0 if that fails. */
int silence(void);
/* The last message of this silent process, without the name of the program. */
void find_message(char text[MESSAGE]);
/* This process has reached the common work, in which failures are agreed on. */
void note_agreement(void);
/* Tells the other processes that this one failed before the common work, if it did. */
void report_early_failure(void);

#endif
