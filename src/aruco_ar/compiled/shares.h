/* Shares, as integers from 0 to 255. */
#pragma once

#include <stdint.h>

/* The product of two shares, rounded. */
static inline uint16_t product(uint16_t a, uint16_t b)
{
    uint16_t sum = a * b + 128;
    return (uint16_t)(sum + (sum >> 8)) >> 8;
}
