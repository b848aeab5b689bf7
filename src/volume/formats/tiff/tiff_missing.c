/* TIFF in builds without libtiff: recognised and written, but not read. */
#include "volume/formats/tiff/signature.h"
#include "volume/io/format.h"

const cvol_format cvol_format_tiff = {
    .name = "TIFF",
    .endings = {".tif", ".tiff"},
    .lacks = "libtiff",
    .recognise = cvol_tiff_recognise,
    .plan = cvol_tiff_plan,
    .holds_series = cvol_tiff_is_ome,
    .takes_folder = 1,
};
