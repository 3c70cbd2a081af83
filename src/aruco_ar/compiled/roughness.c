/* The ground's texture and the camera's noise, put together of tiles. */
#include "unit5.h"

#define SEAM 0.4f  /* width of the strip in which two tiles are mixed, in tiles */

/* Two neighboring tiles in a row or column, from 0 to last, and the weights with which they are mixed. The tiles do not
   depend on each other, so their variances add up. The squares of the weights have the sum 1: the strip between two
   tiles is as rough as they are. */
typedef struct { int tiles[2]; float weights[2]; } Mixture;

static inline Mixture mixture_at(float position, int last)
{
    float before = floorf(position - 0.5f), beyond = within((position - 1 - before) / SEAM + 0.5f, 1);
    float scale = 1 / sqrtf(beyond * beyond + (1 - beyond) * (1 - beyond));
    return (Mixture){{(int)within(before, last), (int)within(before + 1, last)},
                     {(1 - beyond) * scale, beyond * scale}};
}

static inline uint8_t rounded(float value)
{
    return (uint8_t)(within(value, 255) + 0.5f);
}

void unit5_add_roughness(const Image *image, const float *positions, int64_t row, int left, int top,
                         const float *rest, int width, int height, const double to_tiles[9], int count,
                         const int *shifts)
{
    Positions seen = {positions, row};
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            double u = x, v = y;
            if (positions) {
                const float *position = position_of(&seen, x, y);
                u = position[0], v = position[1];
            }
            double scale = 1 / (to_tiles[6] * u + to_tiles[7] * v + to_tiles[8]);
            float across = (float)((to_tiles[0] * u + to_tiles[1] * v + to_tiles[2]) * scale);
            float down = (float)((to_tiles[3] * u + to_tiles[4] * v + to_tiles[5]) * scale);
            if (!(across >= 0 && across <= count && down >= 0 && down <= count))
                continue;
            Mixture columns = mixture_at(across, count - 1), rows = mixture_at(down, count - 1);
            float sum[3] = {0};
            for (int part = 0; part < 4; part++) {
                float weight = columns.weights[part % 2] * rows.weights[part / 2];
                const int *shift = shifts + 2 * (rows.tiles[part / 2] * count + columns.tiles[part % 2]);
                int64_t from_x = (int64_t)x + left + shift[0], from_y = (int64_t)y + top + shift[1];
                if (weight == 0 || from_x < 0 || from_x >= width || from_y < 0 || from_y >= height)
                    continue;
                const float *from = rest + 3 * (width * from_y + from_x);
                for (int channel = 0; channel < 3; channel++)
                    sum[channel] += weight * from[channel];
            }
            uint8_t *pixel = image->pixels + image->row * y + (int64_t)image->channels * x;
            for (int channel = 0; channel < 3; channel++)
                pixel[channel] = rounded(pixel[channel] + sum[channel]);
        }
}
