/* Ground that goes on under a tag: which places beside it show its texture and the camera's noise, and the cover that
   is put together of them. */
#include "sort.h"
#include "unit5.h"
#include "vectors.h"

#define SEAM 0.25f
#define RUN 64
#define MOST_SOURCES 68        /* around 16 rows and columns of tiles */
#define ACROSS 6               /* a source is judged by so many pixels across and down */
#define FEW 4                  /* with fewer sources than this, a tag's place stays smooth */
#define DARK 12.0f             /* gray levels to add to colors before their ratios are taken: noise is no pattern */
/* Sources whose color or roughness differs from the usual one by more than this share, besides what light does to all
   of them, show something in front. If fewer than this share remain, the ground itself has changed. */
#define CHANGED 0.1f
#define CHANGED_ROUGH 0.4f
#define SAME 0.3f
/* This share of the sources is calm. Those whose roughness differs from theirs by more than this share, and so many
   gray levels, show the edges of other things, or a smooth thing. */
#define CALM 0.25f
#define ROUGHER 0.6f
#define LEVELS 1.0f
#define INVISIBLE 0.6f         /* ground with less roughness than this, gray levels, is smooth */
#define FARTHEST_PX 1e9        /* no source is so far away, but of a tag that is, shifts would not be integers */

const double unit5_seam = SEAM, unit5_dark = DARK;
const int unit5_most_sources = MOST_SOURCES;

/* A color, BGR and one more, anywhere in memory. */
typedef Four Pixel __attribute__((aligned(4), may_alias));

/* How two neighbors in a row or column of tiles are mixed, for each pixel of a run; the weight of one may be 0.
   ``before``: the number of the first one; ``from``: where in it the pixel is, in tiles from its middle. The tiles do
   not depend on each other, so their variances add up. The squares of the weights have the sum 1: the strip between two
   tiles is as rough as they are. */
typedef struct { int before[RUN]; float from[RUN], weights[2][RUN]; } Mixtures;

FAST static void find_mixtures(const float *restrict positions, int length, int count, Mixtures *restrict mixtures)
{
    for (int i = 0; i < length; i++) {
        float position = within(positions[i], count);
        int before = (int)(position + 0.5f) - 1;
        float from = position - 0.5f - before, share = smaller(larger((from - 0.5f) / SEAM + 0.5f, 0), 1);
        share = before < 0 ? 1 : before > count - 2 ? 0 : share;
        float scale = 1 / sqrtf(share * share + (1 - share) * (1 - share));
        mixtures->before[i] = before;
        mixtures->from[i] = from;
        mixtures->weights[0][i] = (1 - share) * scale;
        mixtures->weights[1][i] = share * scale;
    }
}

/* Where a homography maps ``length`` points, x and y, at most RUN. */
FAST static void map_run(const double homography[9], const float *restrict x, const float *restrict y, int length,
                         float *restrict across, float *restrict down)
{
    float h[9];
    for (int number = 0; number < 9; number++)
        h[number] = (float)homography[number];
    for (int i = 0; i < length; i++) {
        float scale = 1 / (h[6] * x[i] + h[7] * y[i] + h[8]);
        across[i] = (h[0] * x[i] + h[1] * y[i] + h[2]) * scale;
        down[i] = (h[3] * x[i] + h[4] * y[i] + h[5]) * scale;
    }
}

/* What is not smooth at a pixel, whose number in the run is ``at``. ``x``, ``y``: where it is in the frame. */
static inline Four roughness_at(const Mixtures *across, const Mixtures *down, int at, int x, int y, const Image *frame,
                                int count, const int *shifts, const Pixel *smooth)
{
    Four sum = {0};
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) {
            float weight = down->weights[i][at] * across->weights[j][at];
            if (weight == 0)
                continue;
            int tile = (down->before[at] + i) * count + across->before[at] + j;
            int64_t from_x = (int64_t)x + shifts[2 * tile], from_y = (int64_t)y + shifts[2 * tile + 1];
            if (from_x < 0 || from_x >= frame->width || from_y < 0 || from_y >= frame->height)
                continue;
            const uint8_t *from = frame->pixels + frame->row * from_y + 3 * from_x;
            const Pixel *plane = smooth + 3 * tile;
            sum += ((Four){from[0], from[1], from[2], 0} - plane[0] - plane[1] * (across->from[at] - j)
                    - plane[2] * (down->from[at] - i)) * weight;
        }
    return sum;
}

/* Where the pixels of a run are in a cover: the number of the pixel above and left of it, and how far from that. */
typedef struct { int before[RUN]; float right[RUN], down[RUN]; } Places;

/* ``across``, ``down``: from 0 to 1. ``rows``, ``columns``: of the cover's pixels, at least 2. */
FAST static void find_places(const float *restrict across, const float *restrict down, int length, int rows,
                             int columns, Places *restrict places)
{
    for (int i = 0; i < length; i++) {
        float x = within(across[i] * columns - 0.5f, columns - 1), y = within(down[i] * rows - 0.5f, rows - 1);
        int left = (int)x < columns - 2 ? (int)x : columns - 2, top = (int)y < rows - 2 ? (int)y : rows - 2;
        places->before[i] = columns * top + left;
        places->right[i] = x - left;
        places->down[i] = y - top;
    }
}

static inline Four smooth_at(const Pixel *cover, int columns, const Places *places, int at)
{
    const Pixel *upper = cover + places->before[at], *lower = upper + columns;
    Four high = upper[0] + (upper[1] - upper[0]) * places->right[at];
    Four low = lower[0] + (lower[1] - lower[0]) * places->right[at];
    return high + (low - high) * places->down[at];
}

/* Four numbers for each color of a run, as bytes. */
FAST static void round_run(const float *restrict colors, int length, uint8_t *restrict bytes)
{
    for (int number = 0; number < 4 * length; number++)
        bytes[number] = (uint8_t)(within(colors[number], 255) + 0.5f);
}

void unit5_draw_cover(const Image *image, const Image *mask, const float *positions, int64_t row, int left, int top,
                      int rows, int columns, const float *cover, const double to_cover[9], const Image *frame,
                      int count, const double to_tiles[9], const int *shifts, const float *smooth)
{
    Positions undistorted = {positions, row};
    float x[RUN], y[RUN], across[RUN], down[RUN];
    Places places;
    Mixtures of_columns, of_rows;
    Four colors[RUN] = {{0}};
    uint8_t bytes[4 * RUN];
    for (int line = 0; line < image->height; line++)
        for (int begin = 0; begin < image->width; begin += RUN) {
            int length = image->width - begin < RUN ? image->width - begin : RUN;
            const float *position = positions ? position_of(&undistorted, begin, line) : NULL;
            for (int i = 0; i < length; i++) {
                x[i] = position ? position[2 * i] : left + begin + i;
                y[i] = position ? position[2 * i + 1] : top + line;
            }
            map_run(to_cover, x, y, length, across, down);
            find_places(across, down, length, rows, columns, &places);
            if (count) {
                map_run(to_tiles, x, y, length, across, down);
                find_mixtures(across, length, count, &of_columns);
                find_mixtures(down, length, count, &of_rows);
            }
            const uint8_t *shown = mask->pixels + mask->row * line + 3 * (int64_t)begin;
            for (int i = 0; i < length; i++) {
                if (!shown[3 * i])
                    continue;
                colors[i] = smooth_at((const Pixel *)cover, columns, &places, i);
                if (count && across[i] >= 0 && across[i] < count && down[i] >= 0 && down[i] < count)
                    colors[i] += roughness_at(&of_columns, &of_rows, i, left + begin + i, top + line, frame, count,
                                              shifts, (const Pixel *)smooth);
            }
            round_run((const float *)colors, length, bytes);
            uint8_t *pixel = image->pixels + image->row * line + (int64_t)image->channels * begin;
            for (int i = 0; i < length; i++, pixel += image->channels)
                if (shown[3 * i]) {
                    pixel[0] = bytes[4 * i];
                    pixel[1] = bytes[4 * i + 1];
                    pixel[2] = bytes[4 * i + 2];
                    if (image->channels == 4)
                        pixel[3] = bytes[4 * i + 3];
                }
        }
}

/* What a source shows: its mean color and its roughness, BGR and one more; and its smooth part: see unit5.h. */
typedef struct { float look[4]; Four smooth[3]; } Source;

/* Fit a plane to the colors of ACROSS by ACROSS pixels of a source; its roughness is what remains. ``at``: the middle
   of the source, and the places one tile right of it and below, in the frame. Returns whether that shows it. */
static int find_source(const Image *frame, const double at[6], Source *source)
{
    int sum[3] = {0}, squares[3] = {0}, right[3] = {0}, down[3] = {0};
    /* Across and down, samples are at odd numbers from 1 - ACROSS to ACROSS - 1, in units of this many tiles. */
    double unit = (1 + SEAM) / (2 * (ACROSS - 1)), x_axis[2], y_axis[2];
    for (int axis = 0; axis < 2; axis++) {
        x_axis[axis] = unit * (at[2 + axis] - at[axis]);
        y_axis[axis] = unit * (at[4 + axis] - at[axis]);
    }
    for (int v = 1 - ACROSS; v < ACROSS; v += 2)
        for (int u = 1 - ACROSS; u < ACROSS; u += 2) {
            double x = at[0] + u * x_axis[0] + v * y_axis[0] + 0.5, y = at[1] + u * x_axis[1] + v * y_axis[1] + 0.5;
            if (!(x >= 0 && y >= 0 && x < frame->width && y < frame->height))
                return 0;
            const uint8_t *pixel = frame->pixels + frame->row * (int)y + 3 * (int)x;
            for (int channel = 0; channel < 3; channel++) {
                sum[channel] += pixel[channel];
                squares[channel] += pixel[channel] * pixel[channel];
                right[channel] += u * pixel[channel];
                down[channel] += v * pixel[channel];
            }
        }
    const double all = ACROSS * ACROSS, spread = all * (all - 1) / 3;  /* spread: the sum of u * u, and of v * v */
    double rest = 0;
    for (int channel = 0; channel < 3; channel++) {
        double mean = sum[channel] / all, x = right[channel] / spread, y = down[channel] / spread;
        source->look[channel] = (float)mean;
        source->smooth[0][channel] = (float)mean;
        source->smooth[1][channel] = (float)(x / unit);
        source->smooth[2][channel] = (float)(y / unit);
        rest += squares[channel] - all * mean * mean - spread * (x * x + y * y);
    }
    source->look[3] = (float)sqrt(rest > 0 ? rest / (3 * (all - 3)) : 0);
    return 1;
}

/* What this share of ``count`` values is less than. They are sorted. */
static float middle_of(float *values, int count, float share)
{
    sort(values, count);
    return values[(int)(count * share)];
}

/* Find out which sources show what they usually show, in a light that has changed on all of them: ``same``. Returns
   how many do. ``usual``: of each, as in Source. ``shown``: the numbers of the ``count`` sources to look at. */
static int find_same(const Source *sources, const float (*usual)[4], const int *shown, int count, uint8_t *same)
{
    float changes[3][MOST_SOURCES], light[3], values[MOST_SOURCES];
    for (int channel = 0; channel < 3; channel++) {
        for (int i = 0; i < count; i++)
            values[i] = changes[channel][i] = (sources[shown[i]].look[channel] + DARK)
                                              / (usual[shown[i]][channel] + DARK);
        light[channel] = middle_of(values, count, 0.5f);
    }
    int number = 0;
    for (int i = 0; i < count; i++) {
        float before = usual[shown[i]][3];
        same[i] = fabsf(sources[shown[i]].look[3] - before) < CHANGED_ROUGH * before + LEVELS;
        for (int channel = 0; channel < 3; channel++)
            same[i] &= fabsf(changes[channel][i] / light[channel] - 1) < CHANGED;
        number += same[i];
    }
    return number;
}

/* Of ``count`` sources, keep the numbers of those that show rough ground. Returns how many. ``numbers``: of those that
   the frame shows. The other arguments are those of unit5_choose_sources. */
static int find_usable(const Source *sources, int *numbers, int count, int frames, int learns, float (*usual)[4])
{
    uint8_t same[MOST_SOURCES];
    float rough[MOST_SOURCES];
    int as_usual = find_same(sources, (const float (*)[4])usual, numbers, count, same), usable = 0;
    for (int i = 0; i < count; i++) {
        float *look = usual[numbers[i]];
        if (learns && (same[i] || as_usual < SAME * count))
            for (int part = 0; part < 4; part++)
                look[part] += (sources[numbers[i]].look[part] - look[part]) / frames;
        rough[i] = look[3];
    }
    float calm = middle_of(rough, count, CALM);
    for (int i = 0; i < count && calm > INVISIBLE; i++)
        if (same[i] && fabsf(usual[numbers[i]][3] - calm) <= ROUGHER * calm + LEVELS)
            numbers[usable++] = numbers[i];
    return usable;
}

int unit5_choose_sources(const Image *frame, int count, const double *middles, const double *at, int frames, int learns,
                         float *usual, int tiles, const float *order, double stays, int *shifts, float *smooth)
{
    Source sources[MOST_SOURCES];
    float (*usual_of)[4] = (float (*)[4])usual;
    int numbers[MOST_SOURCES], shown = 0;
    for (int number = 0; number < count; number++) {
        memset(sources + number, 0, sizeof *sources);
        int is_shown = find_source(frame, at + 6 * number, sources + number);
        if (is_shown)
            numbers[shown++] = number;
        if (frames == 1 || (is_shown && usual_of[number][3] < 0)) {
            memcpy(usual_of[number], sources[number].look, sizeof *usual_of);
            usual_of[number][3] = is_shown ? sources[number].look[3] : -1;
        }
    }
    int usable = shown < FEW ? 0 : find_usable(sources, numbers, shown, frames, learns, usual_of);
    if (usable < FEW)
        return 0;
    for (int tile = 0; tile < tiles; tile++) {
        const float *order_of = order + (int64_t)count * tile;
        int chosen = numbers[0], *shift = shifts + 2 * tile;
        for (int i = 1; i < usable; i++)
            if (order_of[numbers[i]] < order_of[chosen])
                chosen = numbers[i];
        double x = at[6 * chosen] - middles[2 * tile], y = at[6 * chosen + 1] - middles[2 * tile + 1];
        if (!(fabs(x - shift[0]) < stays && fabs(y - shift[1]) < stays)) {
            shift[0] = (int)rint(fmin(fmax(x, -FARTHEST_PX), FARTHEST_PX));
            shift[1] = (int)rint(fmin(fmax(y, -FARTHEST_PX), FARTHEST_PX));
        }
        memcpy(smooth + 12 * tile, sources[chosen].smooth, 12 * sizeof *smooth);
    }
    return 1;
}
