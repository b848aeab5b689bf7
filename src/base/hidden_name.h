/* Hidden names for files and folders that are not complete yet. */
#ifndef CVOL_BASE_HIDDEN_NAME_H
#define CVOL_BASE_HIDDEN_NAME_H

/* How many names to try before a folder counts as full of them. */
enum { CVOL_HIDDEN_TRIES = 1000 };

/* FOLDER/.cvol-XXXXXX, for a path FOLDER/NAME. The caller frees it; NULL without memory. */
char *cvol_hidden_name_for(const char *path);

/* Puts other six digits at the end of a name. A process repeats them after 2^24 names. */
void cvol_hidden_name_next(char *name);

/* Creates a file for reading and writing under the next free name. `mode`: its permissions, from
 * which the system takes the umask. Returns the descriptor, or -1 with errno. */
int cvol_hidden_file(char *name, unsigned mode);

/* Creates a folder under the next free name, likewise. 0, or -1 with errno. */
int cvol_hidden_folder(char *name, unsigned mode);

#endif
