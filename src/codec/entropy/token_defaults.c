/* The built-in codes of all rows (token_tables.h). */
#include "codec/entropy/token_tables.h"

const uint8_t cvol_token_defaults[CVOL_ROWS][CVOL_TOKEN_CODES] = {
#include "codec/tables/token_codes.inc"
};
