/* A picture in the light of its wall, which is known at every fourth pixel and interpolated between them.

   A row of the light is stretched first, once for the four rows of the picture above and below it. The rest is the
   same for all numbers of a row, so that compilers can vectorize it. */
#include <stdlib.h>

#include "shares.h"
#include "unit5.h"
#include "vectors.h"

#define STEP 4
#define WEIGHTS (2 * STEP)  /* sum of the weights of two neighbors; the middle of a pixel is at an odd one */

const int unit5_light_step = STEP;

/* A row of the light with a value for each number of the picture's pixels, times WEIGHTS. It begins STEP / 2 pixels
   left of the picture. Alpha is always in full light. */
INLINE void stretch_row(const Image *white, int row, int channels, uint16_t *stretched)
{
    const uint8_t *first = white->pixels + white->row * row;
    for (int column = 0; column <= white->width; column++) {
        const uint8_t *left = first + 3 * (column > 0 ? column - 1 : 0);
        const uint8_t *right = first + 3 * (column < white->width ? column : white->width - 1);
        for (int x = 0; x < STEP; x++)
            for (int channel = 0; channel < channels; channel++) {
                int one = channel < 3 ? left[channel] : 255, other = channel < 3 ? right[channel] : 255;
                *stretched++ = (WEIGHTS - 1 - 2 * x) * one + (1 + 2 * x) * other;
            }
    }
}

/* Change the numbers of a row of a picture. ``below``: the weight of the lower row of the light. ``black``: the level
   of ink for each number. */
INLINE void light_row(uint8_t *restrict numbers, int count, const uint16_t *restrict upper,
                      const uint16_t *restrict lower, uint16_t below, const uint16_t *restrict black)
{
    for (int number = 0; number < count; number++) {
        uint16_t white = (WEIGHTS - below) * upper[number] + below * lower[number] + WEIGHTS * WEIGHTS / 2;
        uint16_t printed = black[number] + product(255 - black[number], numbers[number]);
        numbers[number] = product(printed, white / (WEIGHTS * WEIGHTS));
    }
}

/* ``rows``: room for two rows of the light that are stretched. ``black``: the level of ink for each number of a row. */
INLINE void light_all(const Image *picture, int channels, const Image *mask, const Image *white, uint16_t *rows[2],
                      const uint16_t *black)
{
    int stretched = -1;  /* the last row of the light that is */
    for (int y = 0; y < picture->height; y++) {
        const uint8_t *shown = mask->pixels + mask->row * y;
        int begin = 0, end = picture->width;
        while (begin < end && !shown[3 * begin])
            begin++;
        while (begin < end && !shown[3 * (end - 1)])
            end--;
        if (begin == end)
            continue;
        int at = 2 * y + 1 + STEP, lower = at / WEIGHTS, last = white->height - 1;
        int used[2] = {lower > 0 ? lower - 1 : 0, lower < last ? lower : last};
        for (int number = 0; number < 2; number++)
            if (used[number] > stretched) {
                stretched = used[number];
                stretch_row(white, stretched, channels, rows[stretched % 2]);
            }
        int64_t from = (int64_t)channels * (begin + STEP / 2);
        light_row(picture->pixels + picture->row * y + channels * begin, channels * (end - begin),
                  rows[used[0] % 2] + from, rows[used[1] % 2] + from, at % WEIGHTS, black);
    }
}

/* The same, for pictures with and without alpha. */
FAST static void light_shown(const Image *picture, const Image *mask, const Image *white, uint16_t *rows[2],
                             const uint16_t *black)
{
    if (picture->channels == 4)  /* compilers make faster code if they know the number */
        light_all(picture, 4, mask, white, rows, black);
    else
        light_all(picture, 3, mask, white, rows, black);
}

int unit5_light_picture(const Image *picture, const Image *mask, const Image *white, int black)
{
    int64_t size = (int64_t)picture->channels * STEP * (white->width + 1);
    uint16_t *rows = malloc(3 * size * sizeof *rows), *blacks = rows + 2 * size;
    if (!rows)
        return 0;
    for (int64_t number = 0; number < size; number++)
        blacks[number] = picture->channels == 4 && number % 4 == 3 ? 0 : black;  /* alpha stays as it is */
    light_shown(picture, mask, white, (uint16_t *[2]){rows, rows + size}, blacks);
    free(rows);
    return 1;
}
