/* The ground's texture and the camera's noise, put together of tiles. */
#include "unit5.h"
#include "vectors.h"

#define SEAM 0.25f
#define RUN 64

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

/* Where ``length`` pixels from x on, at most RUN of them, are in tiles. ``h``: unit5_add_roughness's to_tiles. */
FAST static void find_places(const float h[9], const Positions *positions, int x, int y, int length,
                             float *restrict across, float *restrict down)
{
    float u[RUN], v[RUN];
    const float *position = positions->first ? position_of(positions, x, y) : NULL;
    for (int i = 0; i < length; i++) {
        u[i] = position ? position[2 * i] : x + i;
        v[i] = position ? position[2 * i + 1] : y;
    }
    for (int i = 0; i < length; i++) {
        float scale = 1 / (h[6] * u[i] + h[7] * v[i] + h[8]);
        across[i] = (h[0] * u[i] + h[1] * v[i] + h[2]) * scale;
        down[i] = (h[3] * u[i] + h[4] * v[i] + h[5]) * scale;
    }
}

/* Add what is not smooth at a place, in tiles, to a pixel. ``x``, ``y``: where it is in the frame. */
static inline void add_to(uint8_t *pixel, float across, float down, int x, int y, const Image *frame, int count,
                          const int *shifts, const float *smooth)
{
    Mixture columns = mixture_at(across, count - 1), rows = mixture_at(down, count - 1);
    float sum[3] = {0};
    for (int i = 0; i < rows.parts; i++)
        for (int j = 0; j < columns.parts; j++) {
            int tile = rows.tiles[i] * count + columns.tiles[j];
            int64_t from_x = (int64_t)x + shifts[2 * tile], from_y = (int64_t)y + shifts[2 * tile + 1];
            if (from_x < 0 || from_x >= frame->width || from_y < 0 || from_y >= frame->height)
                continue;
            const uint8_t *from = frame->pixels + frame->row * from_y + 3 * from_x;
            const float *plane = smooth + 9 * tile;
            float weight = rows.weights[i] * columns.weights[j];
            for (int channel = 0; channel < 3; channel++)
                sum[channel] += weight * (from[channel] - plane[channel] - plane[3 + channel] * columns.from[j]
                                          - plane[6 + channel] * rows.from[i]);
        }
    for (int channel = 0; channel < 3; channel++)
        pixel[channel] = (uint8_t)(within(pixel[channel] + sum[channel], 255) + 0.5f);
}

void unit5_add_roughness(const Image *image, const float *positions, int64_t row, int left, int top,
                         const Image *frame, const double to_tiles[9], int count, const int *shifts,
                         const float *smooth)
{
    Positions seen = {positions, row};
    float h[9], across[RUN], down[RUN];
    for (int number = 0; number < 9; number++)
        h[number] = (float)to_tiles[number];
    for (int y = 0; y < image->height; y++)
        for (int begin = 0; begin < image->width; begin += RUN) {
            int length = image->width - begin < RUN ? image->width - begin : RUN;
            find_places(h, &seen, begin, y, length, across, down);
            uint8_t *pixels = image->pixels + image->row * y + (int64_t)image->channels * begin;
            for (int x = 0; x < length; x++)
                if (across[x] >= 0 && across[x] < count && down[x] >= 0 && down[x] < count)
                    add_to(pixels + image->channels * x, across[x], down[x], left + begin + x, top + y, frame, count,
                           shifts, smooth);
        }
}
