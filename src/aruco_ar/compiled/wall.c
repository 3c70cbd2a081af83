/* Comparing a rectified frame with the wall as it is known, and learning the wall from it. */
#include <stdlib.h>

#include "unit5.h"

/* How much a pixel may differ from the wall. Light changes its color by less than SHARE of the brightness. Noise
   changes it by less than DEVIATIONS standard deviations plus LEVELS gray levels. The rims of a pattern may be blurred
   or off by a pixel. There it may also differ by RIM_SHARE of the contrast nearby. */
#define SHARE 0.08f
/* Where the wall was first seen in a shadow, and the rest is in one now, light has changed by a large factor. Then it
   may change the color by up to TINT more, beyond the factor TINTED_FROM. */
#define TINTED_FROM 2.0f
#define TINT 0.2f
#define DEVIATIONS 3.5f
#define LEVELS 2.0f
#define RIM_SHARE 0.6f
#define SHARP 0.22f        /* the rim of a shadow is softer than this change of the light's logarithm in 3 pixels */
#define STEP_FROM 1.1f     /* where the light in 3 pixels varies by a smaller factor, there is no rim of a shadow */
#define MIN_LIGHT 0.02f
#define WEAK 0.5f          /* a pixel that differs by a larger share of what is allowed tells nothing about noise */
#define LIGHT_CHANGE 0.1f  /* the look is learned where the light differs less from that on the whole wall */

/* What unit5_compare_wall finds out about each pixel: planes of floats, one after the other. */
enum { GRAY, WALL_GRAY, LIGHT, ERROR, EXCESS, STEP, NOISE, RIM, PLANES };
const int unit5_plane_count = PLANES;

static inline float mean3(float one, float two, float three) { return (one + two + three) / 3; }

/* A channel of a pixel: how far it is off the wall in this light, in gray levels, and as a share of what is allowed. */
static inline void compare_channel(float seen, float wall, float light, float contrast, float noise, float *error,
                                   float *excess)
{
    float lit = wall * light, off = fabsf(seen - lit), share = SHARE + TINT * larger(1 - TINTED_FROM / light, 0);
    *error = larger(*error, off);
    *excess = larger(*excess, off / (share * lit + RIM_SHARE * contrast * light + noise));
}

/* The part of unit5_compare_wall that looks at a pixel alone. */
static void compare_pixels(const uint8_t *restrict seen, const float *restrict look, const float whole[3],
                           const uint8_t *restrict contrast, const float *restrict variance, int64_t count,
                           float *restrict planes)
{
    float blue = whole[0], green = whole[1], red = whole[2];
    for (int64_t at = 0; at < count; at++) {
        float b = look[3 * at] * blue, g = look[3 * at + 1] * green, r = look[3 * at + 2] * red;
        float gray = mean3(seen[3 * at], seen[3 * at + 1], seen[3 * at + 2]), wall_gray = larger(mean3(b, g, r), 1);
        float light = gray / wall_gray, noise = LEVELS + DEVIATIONS * sqrtf(variance[at]), error = 0, excess = 0;
        compare_channel(seen[3 * at], b, light, contrast[3 * at], noise, &error, &excess);
        compare_channel(seen[3 * at + 1], g, light, contrast[3 * at + 1], noise, &error, &excess);
        compare_channel(seen[3 * at + 2], r, light, contrast[3 * at + 2], noise, &error, &excess);
        planes[GRAY * count + at] = gray;
        planes[WALL_GRAY * count + at] = wall_gray;
        planes[LIGHT * count + at] = light;
        planes[ERROR * count + at] = error;
        planes[EXCESS * count + at] = excess;
        planes[NOISE * count + at] = noise;
        planes[RIM * count + at] = RIM_SHARE * mean3(contrast[3 * at], contrast[3 * at + 1], contrast[3 * at + 2]);
    }
}

int unit5_compare_wall(const uint8_t *seen, const float *look, const float whole[3], const uint8_t *contrast,
                       const float *variance, const uint8_t *usable, int width, int height, float darkest,
                       float lightest, float *planes, uint8_t *front)
{
    int64_t count = (int64_t)width * height;
    float *least = malloc(2 * sizeof(float) * width + 1), *most = least + width;  /* the light in three rows */
    if (!least)
        return 0;
    compare_pixels(seen, look, whole, contrast, variance, count, planes);
    const float *lights = planes + LIGHT * count;
    for (int y = 0; y < height; y++) {
        const float *row = lights + (int64_t)y * width;
        const float *upper = y > 0 ? row - width : row, *lower = y < height - 1 ? row + width : row;
        for (int x = 0; x < width; x++) {
            least[x] = smaller(smaller(upper[x], row[x]), lower[x]);
            most[x] = larger(larger(upper[x], row[x]), lower[x]);
        }
        for (int x = 0; x < width; x++) {
            int64_t at = (int64_t)y * width + x;
            int left = x > 0 ? x - 1 : x, right = x < width - 1 ? x + 1 : x;
            float low = larger(smaller(smaller(least[left], least[x]), least[right]), MIN_LIGHT);
            float high = larger(larger(most[left], most[x]), most[right]);
            float slack = planes[NOISE * count + at] * 2 / 3 + planes[RIM * count + at];
            slack /= planes[WALL_GRAY * count + at];
            float step = 0;
            if (high > STEP_FROM * low)
                step = (logf(high / low) - 2 * slack / larger(row[x], 0.1f)) / SHARP;
            planes[STEP * count + at] = step;
            front[at] = usable[at] && (planes[EXCESS * count + at] > 1 || step > 1 || row[x] < darkest - slack
                                       || row[x] > lightest + slack);
        }
    }
    free(least);
    return 1;
}

void unit5_learn_wall(const uint8_t *seen, const float whole[3], const float *planes, const uint8_t *wall,
                      const uint8_t *certain, int64_t count, float passed, float settle, float rate,
                      float variance_rate, float *look, float *variance, uint8_t *known, float *seconds)
{
    const float *light = planes + LIGHT * count, *error = planes + ERROR * count, *excess = planes + EXCESS * count;
    float back[3] = {1 / whole[0], 1 / whole[1], 1 / whole[2]};
    for (int64_t at = 0; at < count; at++) {
        seconds[at] = smaller(seconds[at] + (wall[at] ? passed : 0), settle);
        int is_new = wall[at] && !known[at];
        float part = is_new ? 1 : certain[at] && fabsf(light[at] - 1) < LIGHT_CHANGE ? rate : 0;
        for (int channel = 0; channel < 3; channel++)
            look[3 * at + channel] += part * (seen[3 * at + channel] * back[channel] - look[3 * at + channel]);
        known[at] |= is_new;
        if (certain[at] && excess[at] < WEAK)
            variance[at] += variance_rate * (error[at] * error[at] - variance[at]);
    }
}
