/* A folder that is written: it gets its name only when it is complete. */
#ifndef CVOL_VOLUME_FORMATS_ZARR_FOLDER_H
#define CVOL_VOLUME_FORMATS_ZARR_FOLDER_H

#include "cvol/base.h"

typedef struct cvol_zarr_folder {
    char *name;      /* of messages */
    char *final;     /* links resolved */
    char *temporary; /* hidden, in the same folder */
} cvol_zarr_folder;

/* Makes the temporary folder. Only a folder that cvol could have written is replaced. The caller
 * ends it with commit or abandon. Errors: IO, MEMORY. */
int cvol_zarr_folder_open(cvol_context *context, cvol_zarr_folder *folder, const char *path);
/* Writes a file, and the folders of its name. Threads may call it at once, each with its own
 * context. Errors: IO, MEMORY. */
int cvol_zarr_folder_write(cvol_context *context, const cvol_zarr_folder *folder, const char *name,
                           const void *data, size_t size);
/* Syncs, and gives the folder its name. An older one is removed. */
int cvol_zarr_folder_commit(cvol_context *context, cvol_zarr_folder *folder);
/* Removes the temporary folder, if there is one, and frees the names. */
void cvol_zarr_folder_abandon(cvol_zarr_folder *folder);

#endif
