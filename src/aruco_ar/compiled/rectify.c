/* A view of a plane in a frame, straight from the front. */
#include "sampling.h"
#include "unit5.h"
#include "vectors.h"

#define CHANNELS 3
#define RUN 64

/* Where a homography maps RUN pixels of a row from ``left`` on. */
FAST static void map_run(const double homography[9], int left, int y, float *restrict across, float *restrict down)
{
    float h[9];
    for (int number = 0; number < 9; number++)
        h[number] = (float)homography[number];
    for (int i = 0; i < RUN; i++) {
        float x = (float)(left + i), scale = 1 / (h[6] * x + h[7] * y + h[8]);
        across[i] = (h[0] * x + h[1] * y + h[2]) * scale;
        down[i] = (h[3] * x + h[4] * y + h[5]) * scale;
    }
}

/* The same for ``length`` pixels by a grid of positions, whose rows have ``columns``; between its places, every ``step`` pixels, it is linear. */
static void place_run(const double *grid, int columns, int step, int left, int y, int length, float *across, float *down)
{
    const double *upper = grid + 2 * (int64_t)columns * (y / step), *lower = upper + 2 * columns;
    double below = (double)(y % step) / step;
    for (int i = 0; i < length;) {
        int from = (left + i) % step, count = step - from < length - i ? step - from : length - i;
        double before[2], slope[2];
        for (int axis = 0; axis < 2; axis++) {
            int at = 2 * ((left + i) / step) + axis;
            before[axis] = upper[at] + below * (lower[at] - upper[at]);
            slope[axis] = (upper[at + 2] + below * (lower[at + 2] - upper[at + 2]) - before[axis]) / step;
        }
        for (int x = from; x < from + count; x++, i++) {
            across[i] = (float)(before[0] + x * slope[0]);
            down[i] = (float)(before[1] + x * slope[1]);
        }
    }
}

/* Where pixels are sampled: the byte of the frame, and the weights for the steps from that pixel, in bytes too. */
typedef struct { int64_t byte[RUN]; int x[RUN], y[RUN]; } Samples;

/* Returns how many of the places are within the frame, and may be read as they are. */
FAST static int find_samples(const Image *frame, const float *restrict across, const float *restrict down,
                             Samples *restrict samples)
{
    float last_x = frame->width - 1, last_y = frame->height - 1;
    int last_u = STEPS * (frame->width - 1) - 1, last_v = STEPS * (frame->height - 1) - 1, count = 0;
    int u[RUN], v[RUN];
    for (int i = 0; i < RUN; i++) {
        float x = within(across[i], last_x), y = within(down[i], last_y);
        count += (x == across[i]) & (y == down[i]);
        u[i] = (int)(STEPS * x + 0.5f);
        v[i] = (int)(STEPS * y + 0.5f);
        u[i] = u[i] < last_u ? u[i] : last_u;
        v[i] = v[i] < last_v ? v[i] : last_v;
        samples->x[i] = (u[i] & (STEPS - 1)) * (int)sizeof(Pair);
        samples->y[i] = (v[i] & (STEPS - 1)) * (int)sizeof(Pair);
    }
    for (int i = 0; i < RUN; i++)
        samples->byte[i] = frame->row * (v[i] >> STEP_BITS) + CHANNELS * (u[i] >> STEP_BITS);
    return count;
}

/* ``bytes``: see load_pair. */
INLINE void sample_all(const Image *frame, const Samples *samples, int bytes, const Weights *weights, uint8_t *pixel)
{
    for (int i = 0; i < RUN; i++, pixel += CHANNELS)
        put_mean(pixel, sample_pair(frame->pixels + samples->byte[i], frame->row, bytes, weights, samples->x[i],
                                    samples->y[i]), CHANNELS, 6);
}

/* Set RUN pixels to what a frame shows at places; black beyond it. */
FAST static void sample_run(const Image *frame, const float *across, const float *down, const Weights *weights,
                            uint8_t *pixels)
{
    Samples samples;
    int inside = find_samples(frame, across, down, &samples), is_low = frame->row < 0;
    for (int i = 0; i < RUN; i++)  /* from the last row in memory, nothing may be read behind the end */
        is_low |= !(down[i] < frame->height - 2);
    if (is_low)
        sample_all(frame, &samples, 2 * CHANNELS, weights, pixels);
    else
        sample_all(frame, &samples, 8, weights, pixels);
    for (int i = 0; i < RUN && inside < RUN; i++)
        if (!(across[i] >= 0 && across[i] <= frame->width - 1 && down[i] >= 0 && down[i] <= frame->height - 1))
            memset(pixels + CHANNELS * i, 0, CHANNELS);
}

void unit5_rectify(const Image *frame, const Image *view, const double homography[9], const double *grid, int columns,
                   int step)
{
    Weights weights;
    float across[RUN] = {0}, down[RUN] = {0};
    uint8_t pixels[CHANNELS * RUN + 1];
    find_weights(&weights, CHANNELS);
    for (int y = 0; y < view->height; y++)
        for (int left = 0; left < view->width; left += RUN) {
            int length = view->width - left < RUN ? view->width - left : RUN;
            if (grid)
                place_run(grid, columns, step, left, y, length, across, down);
            else
                map_run(homography, left, y, across, down);
            sample_run(frame, across, down, &weights, pixels);
            memcpy(view->pixels + view->row * y + CHANNELS * left, pixels, CHANNELS * length);
        }
}
