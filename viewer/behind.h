/* Work that gives way to what somebody waits for: films and copies, beside frames. */
#ifndef CVOL_VIEWER_BEHIND_H
#define CVOL_VIEWER_BEHIND_H

/* The thread that calls it, and those that it starts, take processors only as far as others leave
 * them; where the system has no such thing, nothing changes. */
void work_behind(void);

#endif
