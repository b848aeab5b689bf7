/* Work in the background. */
#ifndef CVOL_VIEWER_BASE_BACKGROUND_H
#define CVOL_VIEWER_BASE_BACKGROUND_H

/* Runs a function on a thread of its own; 0 on success. A service without threads runs it at once
 * (web/no_threads.c). */
int run_in_background(void *(*run)(void *), void *argument);

#endif
