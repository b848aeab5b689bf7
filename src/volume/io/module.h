/* Modules: parts of the library that depend on large libraries are separate shared objects. They
 * are loaded when a file needs them, so other files do not wait for these libraries to start. */
#ifndef CVOL_VOLUME_IO_MODULE_H
#define CVOL_VOLUME_IO_MODULE_H

/* The function `symbol` of a module (a file's name); NULL if there is none. The module is searched
 * next to the program or library that contains this code, and in the installation's folder of
 * modules. */
void *cvol_module_find(const char *module, const char *symbol);

#endif
