/* The trained numbers of the network that predicts masked samples, and the probabilities of its
 * levels (mask_predict.h). */
#include "codec/mask/mask_predict.h"

const cvol_mask_network cvol_mask_trained = {
#include "codec/tables/mask_network.inc"
};

const uint16_t cvol_mask_probabilities[CVOL_MASK_LEVELS] = {
#include "codec/tables/mask_levels.inc"
};
