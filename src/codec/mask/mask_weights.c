/* The trained numbers of the network that predicts masked samples (mask_predict.h). */
#include "codec/mask/mask_predict.h"

const cvol_mask_network cvol_mask_trained = {
#include "codec/tables/mask_network.inc"
};
