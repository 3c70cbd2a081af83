/* The ground's texture and the camera's noise, put together of tiles. */
#include "unit5.h"

#define SEAM 0.25f

const double unit5_seam = SEAM;

/* One tile in a row or column, or two neighbors that are mixed. ``from``: of each, where in it the pixel is, in tiles
   from its middle. The tiles do not depend on each other, so their variances add up. The squares of the weights have
   the sum 1: the strip between two tiles is as rough as they are. */
typedef struct { int parts, tiles[2]; float weights[2], from[2]; } Mixture;

static inline Mixture mixture_at(float position, int last)
{
    int before = (int)(position + 0.5f) - 1, beyond = before + 1;
    float from = position - 0.5f - before, share = (from - 0.5f) / SEAM + 0.5f;
    if (share <= 0 || beyond > last)
        return (Mixture){1, {before, before}, {1, 0}, {from, 0}};
    if (share >= 1 || before < 0)
        return (Mixture){1, {beyond, beyond}, {1, 0}, {from - 1, 0}};
    float scale = 1 / sqrtf(share * share + (1 - share) * (1 - share));
    return (Mixture){2, {before, beyond}, {(1 - share) * scale, share * scale}, {from, from - 1}};
}

void unit5_add_roughness(const Image *image, const float *positions, int64_t row, int left, int top,
                         const Image *frame, const double to_tiles[9], int count, const int *shifts,
                         const float *planes)
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
            if (!(across >= 0 && across < count && down >= 0 && down < count))
                continue;
            Mixture columns = mixture_at(across, count - 1), rows = mixture_at(down, count - 1);
            float sum[3] = {0};
            for (int i = 0; i < rows.parts; i++)
                for (int j = 0; j < columns.parts; j++) {
                    int tile = rows.tiles[i] * count + columns.tiles[j];
                    int64_t from_x = (int64_t)x + left + shifts[2 * tile];
                    int64_t from_y = (int64_t)y + top + shifts[2 * tile + 1];
                    if (from_x < 0 || from_x >= frame->width || from_y < 0 || from_y >= frame->height)
                        continue;
                    const uint8_t *from = frame->pixels + frame->row * from_y + 3 * from_x;
                    const float *plane = planes + 9 * tile;
                    float weight = rows.weights[i] * columns.weights[j];
                    for (int channel = 0; channel < 3; channel++)
                        sum[channel] += weight * (from[channel] - plane[channel] - plane[3 + channel] * columns.from[j]
                                                  - plane[6 + channel] * rows.from[i]);
                }
            uint8_t *pixel = image->pixels + image->row * y + (int64_t)image->channels * x;
            for (int channel = 0; channel < 3; channel++)
                pixel[channel] = (uint8_t)(within(pixel[channel] + sum[channel], 255) + 0.5f);
        }
}
