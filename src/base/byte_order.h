/* The machine's byte order, and conversion to the other one. */
#ifndef CVOL_BASE_BYTE_ORDER_H
#define CVOL_BASE_BYTE_ORDER_H

#include <stddef.h>
#include <stdint.h>

/* 1 if the machine is big-endian. */
int cvol_machine_is_big_endian(void);
/* The number of four bytes, the high byte first. */
uint32_t cvol_high_first(const uint8_t bytes[4]);
/* Reverses the bytes of each of `count` elements of `size` bytes (1, 2, 4, 8). */
void cvol_swap_bytes(void *data, size_t count, size_t size);

#endif
