/* The trained numbers of the two networks and of the rows with them (neural_model.h). */
#include "codec/neural/neural_model.h"

const cvol_neural_network cvol_neural_magnitudes = {
#include "codec/tables/neural_magnitudes.inc"
};

const cvol_neural_network cvol_neural_signs = {
#include "codec/tables/neural_signs.inc"
};

const uint8_t cvol_neural_rows[CVOL_NEURAL_ROWS_END - CVOL_NEURAL_ROWS][CVOL_TOKEN_CODES] = {
#include "codec/tables/neural_rows.inc"
};
