/* The fields of NIfTI headers. */
#include "volume/formats/nifti_fields.h"

#include <string.h>

const cvol_nifti_layout cvol_nifti_layouts[2] = {
    {.version = 1,
     .size = 348,
     .magic = "n+1",
     .pair_magic = "ni1",
     .magic_at = 344,
     .dim = 40,
     .dim_width = 2,
     .datatype = 70,
     .bitpix = 72,
     .pixdim = 76,
     .real_width = 4,
     .vox_offset = 108,
     .scl_slope = 112,
     .scl_inter = 116,
     .qform_code = 252,
     .sform_code = 254,
     .code_width = 2,
     .quatern = 256,
     .qoffset = 268,
     .srow = 280,
     .xyzt_units = 123,
     .units_width = 1},
    {.version = 2,
     .size = 540,
     .magic = "n+2",
     .pair_magic = "ni2",
     .magic_at = 4,
     .dim = 16,
     .dim_width = 8,
     .datatype = 12,
     .bitpix = 14,
     .pixdim = 104,
     .real_width = 8,
     .vox_offset = 168,
     .scl_slope = 176,
     .scl_inter = 184,
     .qform_code = 344,
     .sform_code = 348,
     .code_width = 4,
     .quatern = 352,
     .qoffset = 376,
     .srow = 400,
     .xyzt_units = 500,
     .units_width = 4},
};

static uint64_t get_bits(const cvol_nifti_header *header, size_t at, size_t width)
{
    uint64_t bits = 0;
    for (size_t i = 0; i < width; i++) {
        size_t significance = header->big_endian ? width - 1 - i : i;
        bits |= (uint64_t)header->bytes[at + i] << 8 * significance;
    }
    return bits;
}

int64_t cvol_nifti_get_integer(const cvol_nifti_header *header, size_t at, size_t width)
{
    uint64_t bits = get_bits(header, at, width);
    switch (width) {
    case 1:
        return (int8_t)bits;
    case 2:
        return (int16_t)bits;
    case 4:
        return (int32_t)bits;
    default:
        return (int64_t)bits;
    }
}

/* The i-th of the reals that begin at `at`. */
double cvol_nifti_get_real(const cvol_nifti_header *header, size_t at, size_t i)
{
    uint64_t bits = get_bits(header, at + i * header->at->real_width, header->at->real_width);
    if (header->at->real_width == 4) {
        uint32_t low = (uint32_t)bits;
        float value;
        memcpy(&value, &low, sizeof value);
        return value;
    }
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Headers are written little-endian. */
void cvol_nifti_put_integer(uint8_t *header, size_t at, size_t width, int64_t value)
{
    for (size_t i = 0; i < width; i++)
        header[at + i] = (uint8_t)((uint64_t)value >> 8 * i);
}

void cvol_nifti_put_real(uint8_t *header, const cvol_nifti_layout *layout, size_t at, size_t i,
                         double value)
{
    uint64_t bits;
    if (layout->real_width == 4) {
        float narrow = (float)value;
        uint32_t low;
        memcpy(&low, &narrow, sizeof low);
        bits = low;
    } else
        memcpy(&bits, &value, sizeof bits);
    cvol_nifti_put_integer(header, at + i * layout->real_width, layout->real_width, (int64_t)bits);
}

/* Finds version and byte order by sizeof_hdr; 0 if it has no valid value. */
int cvol_nifti_find_layout(cvol_nifti_header *header, size_t size)
{
    for (size_t v = 0; v < 2; v++)
        for (header->big_endian = 0; size >= 4 && header->big_endian < 2; header->big_endian++)
            if (get_bits(header, 0, 4) == cvol_nifti_layouts[v].size) {
                header->at = &cvol_nifti_layouts[v];
                return 1;
            }
    return 0;
}
