/* Background work: animations and copies yield to frames, for which a user waits. */
#ifndef CVOL_VIEWER_BASE_PRIORITY_H
#define CVOL_VIEWER_BASE_PRIORITY_H

/* Lowers the priority of the calling thread, and of threads that it starts, if the system can. */
void lower_thread_priority(void);

#endif
