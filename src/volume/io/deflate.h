/* gzip and zlib streams inside files, deflated part by part. */
#ifndef CVOL_VOLUME_IO_DEFLATE_H
#define CVOL_VOLUME_IO_DEFLATE_H

#include "cvol/base.h"

struct cvol_output;

typedef struct cvol_deflater cvol_deflater;

/* Writes a gzip or else a zlib stream to an output, which must outlive the deflater. */
int cvol_deflater_open(cvol_context *context, cvol_deflater **out, struct cvol_output *output,
                       int gzip);
void cvol_deflater_close(cvol_deflater *deflater);
/* size < 4 GiB. The stream's bytes may depend on the sizes of the parts. */
int cvol_deflater_write(cvol_context *context, cvol_deflater *deflater, const void *data,
                        size_t size);
/* Ends the stream; *size is its size in bytes. */
int cvol_deflater_finish(cvol_context *context, cvol_deflater *deflater, uint64_t *size);

#endif
