/* Sampling a picture between its pixels: eight numbers at a time, in the vector registers of the processor. */
#pragma once

#include "image.h"
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#define STEP_BITS 7
#define STEPS (1 << STEP_BITS)  /* positions are rounded to this many steps per pixel */

/* Two neighboring pixels of a row, channel after channel; of BGR, two more numbers follow, which say nothing. */
typedef uint16_t Pair __attribute__((vector_size(16)));

/* The weights of the lower one of two rows, and of both pixels of a row, for each step. Behind the last pixel of the
   picture there is no other, so that the last step before a pixel stands for the pixel itself. */
typedef struct { Pair lower[STEPS], across[STEPS]; } Weights;

static inline void find_weights(Weights *weights, int channels)
{
    for (int step = 0; step < STEPS; step++) {
        int next = step < STEPS - 1 ? step : STEPS;
        for (int lane = 0; lane < 8; lane++) {
            weights->lower[step][lane] = next;
            weights->across[step][lane] = lane < channels ? 256 * (STEPS - next) : lane < 2 * channels ? 256 * next : 0;
        }
    }
}

/* ``count``: of bytes to read. It is 8, unless the last ones are behind the end of the picture; that takes longer. */
static inline Pair load_pair(const uint8_t *bytes, int count)
{
    uint8_t copy[8] = {0};
    if (count < 8)
        bytes = memcpy(copy, bytes, count);
#ifdef __SSE2__
    return (Pair)_mm_unpacklo_epi8(_mm_loadl_epi64((const __m128i *)bytes), _mm_setzero_si128());
#else
    typedef uint8_t Bytes __attribute__((vector_size(8)));
    Bytes both;
    memcpy(&both, bytes, 8);
    return __builtin_convertvector(both, Pair);
#endif
}

/* The upper 16 bits of each product. */
static inline Pair multiply_high(Pair a, Pair b)
{
#ifdef __SSE2__
    return (Pair)_mm_mulhi_epu16((__m128i)a, (__m128i)b);
#else
    typedef uint32_t Products __attribute__((vector_size(32)));
    return __builtin_convertvector(__builtin_convertvector(a, Products) * __builtin_convertvector(b, Products) >> 16,
                                   Pair);
#endif
}

/* A sample, as two parts, one of each pixel of the pair: 64 times what they are of the color. ``upper``: the pixel at
   the top left of the four; ``below``: the bytes to the one below. ``count``: see load_pair. ``x``, ``y``: where the
   weights for the steps from there are, in bytes. */
static inline Pair sample_pair(const uint8_t *upper, int64_t below, int count, const Weights *weights, int x, int y)
{
    Pair top = load_pair(upper, count), foot = load_pair(upper + below, count);
    /* Of what is negative here, the lower 16 bits are right, and the sum is not negative. */
    Pair lower = *(const Pair *)((const char *)weights->lower + y);
    return multiply_high(STEPS * top + (foot - top) * lower, *(const Pair *)((const char *)weights->across + x));
}

/* Set a pixel to the mean of samples whose sum this is. ``shift``: of 64 times their number, a power of 2. */
static inline void put_mean(uint8_t *pixel, Pair sum, int channels, int shift)
{
#ifdef __SSE2__
    __m128i next = channels == 3 ? _mm_srli_si128((__m128i)sum, 6) : _mm_srli_si128((__m128i)sum, 8);
    __m128i mean = (__m128i)((sum + (Pair)next + (uint16_t)(1 << shift >> 1)) >> shift);
    int bytes = _mm_cvtsi128_si32(_mm_packus_epi16(mean, mean));
    memcpy(pixel, &bytes, channels);
#else
    for (int channel = 0; channel < channels; channel++)
        pixel[channel] = (sum[channel] + sum[channel + channels] + (1 << shift >> 1)) >> shift;
#endif
}
