/* A palette of few colours, from the pictures that it will be used for. */
#ifndef CVOL_IMAGE_PALETTE_H
#define CVOL_IMAGE_PALETTE_H

#include <stddef.h>
#include <stdint.h>

#define CVOL_PALETTE_MAX 255

typedef struct cvol_palette cvol_palette;

/* NULL without memory. */
cvol_palette *cvol_palette_create(void);
void cvol_palette_free(cvol_palette *palette);
/* Counts colours, R G B A in bytes; A is ignored. */
void cvol_palette_count(cvol_palette *palette, const uint8_t *rgba, size_t pixels);
/* Chooses at most CVOL_PALETTE_MAX colours, and ends the counting. 0 without memory. */
int cvol_palette_choose(cvol_palette *palette);
int cvol_palette_size(const cvol_palette *palette);
const uint8_t *cvol_palette_colour(const cvol_palette *palette, int index); /* R G B */
/* The palette colours of a row of pixels, dithered by position. */
void cvol_palette_map(cvol_palette *palette, uint8_t *indices, const uint8_t *rgba, int width,
                      int y);

#endif
