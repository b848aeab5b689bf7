/* Parts of the library that stand on large libraries are modules of their own, which are loaded
 * when a file wants them: others do not wait for these libraries to start. */
#ifndef CVOL_VOLUME_IO_MODULE_H
#define CVOL_VOLUME_IO_MODULE_H

/* The function `symbol` of a module (a file's name); NULL if there is none. The module is searched
 * next to the program or library that contains this code, and where an installation puts it. */
void *cvol_module_find(const char *module, const char *symbol);

#endif
