/* Places of the fields of NIfTI headers, and their values in either byte order. */
#ifndef CVOL_VOLUME_FORMATS_NIFTI_FIELDS_H
#define CVOL_VOLUME_FORMATS_NIFTI_FIELDS_H

#include <stddef.h>
#include <stdint.h>

#define CVOL_NIFTI_LONGEST_HEADER 540

/* Offsets of the fields in bytes, and the widths of integers of each kind and of reals. */
typedef struct cvol_nifti_layout {
    int version;
    size_t size;
    const char *magic, *pair_magic; /* single file, header of a pair */
    size_t magic_at, dim, dim_width, datatype, bitpix, pixdim, real_width, vox_offset, scl_slope,
        scl_inter, qform_code, sform_code, code_width, quatern, qoffset, srow, xyzt_units,
        units_width;
} cvol_nifti_layout;

/* NIfTI-1 and NIfTI-2. */
extern const cvol_nifti_layout cvol_nifti_layouts[2];

/* The bytes of a header. */
typedef struct cvol_nifti_header {
    const cvol_nifti_layout *at;
    int big_endian;
    uint8_t bytes[CVOL_NIFTI_LONGEST_HEADER];
} cvol_nifti_header;

/* Finds version and byte order by sizeof_hdr in the first `size` bytes; 0 if it has no valid
 * value. */
int cvol_nifti_find_layout(cvol_nifti_header *header, size_t size);
/* The signed integer of `width` bytes (1, 2, 4, 8) at an offset. */
int64_t cvol_nifti_get_integer(const cvol_nifti_header *header, size_t at, size_t width);
/* The i-th of the reals that begin at an offset. */
double cvol_nifti_get_real(const cvol_nifti_header *header, size_t at, size_t i);

/* The same for writing headers, which are little-endian. */
void cvol_nifti_put_integer(uint8_t *header, size_t at, size_t width, int64_t value);
void cvol_nifti_put_real(uint8_t *header, const cvol_nifti_layout *layout, size_t at, size_t i,
                         double value);

#endif
