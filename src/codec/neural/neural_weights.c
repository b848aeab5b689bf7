/* The trained numbers of the two networks and of the rows beside them (neural_model.h). */
#include "codec/neural/neural_model.h"

const cvol_small_network cvol_small_magnitudes = {
#include "codec/tables/neural_magnitudes.inc"
};

const cvol_small_network cvol_small_signs = {
#include "codec/tables/neural_signs.inc"
};

const uint8_t cvol_small_rows[CVOL_SMALL_ROWS_END - CVOL_SMALL_ROWS][CVOL_TOKEN_CODES] = {
#include "codec/tables/neural_rows.inc"
};
