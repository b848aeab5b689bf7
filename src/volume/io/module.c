/* Modules that are loaded when they are needed. */
#define _GNU_SOURCE
#include "volume/io/module.h"

#include <dlfcn.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/auxv.h>
#endif

#ifndef CVOL_MODULE_FOLDER
#define CVOL_MODULE_FOLDER "/usr/local/lib/cvol"
#endif

/* The folder of the program or library that has this function, up to its slash; 0 if it is
 * unknown. */
static int own_folder(char out[PATH_MAX])
{
    Dl_info info;
    static const char here = 0;
    char *path = dladdr(&here, &info) && info.dli_fname ? realpath(info.dli_fname, NULL) : NULL;
    if (!path) /* the dynamic linker gives programs the name by which they were called */
        path = realpath("/proc/self/exe", NULL);
#ifdef __linux__
    if (!path) /* if /proc is not mounted */
        path = realpath((const char *)getauxval(AT_EXECFN), NULL);
#endif
    char *slash = path ? strrchr(path, '/') : NULL;
    if (slash)
        slash[1] = '\0';
    int found = slash && snprintf(out, PATH_MAX, "%s", path) < PATH_MAX;
    free(path);
    return found;
}

void *cvol_module_find(const char *module, const char *symbol)
{
    static const char *const places[] = {"", "../", "../../", "cvol/", "../lib/cvol/"};
    char folder[PATH_MAX], path[PATH_MAX + 64];
    void *handle = NULL;
    if (own_folder(folder))
        for (size_t i = 0; !handle && i < sizeof places / sizeof *places; i++)
            if (snprintf(path, sizeof path, "%s%s%s", folder, places[i], module) < (int)sizeof path)
                handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!handle) {
        snprintf(path, sizeof path, "%s/%s", CVOL_MODULE_FOLDER, module);
        handle = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    }
    /* It stays loaded: its libraries may crash when they are unloaded. */
    return handle ? dlsym(handle, symbol) : NULL;
}
