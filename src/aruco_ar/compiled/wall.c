/* Comparing a rectified frame with the wall as it is known, and learning the wall from it. */
#include <stdlib.h>

#include "unit5.h"
#include "vectors.h"

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
#define WEAK_STEP 0.5f     /* a smaller step of the light is no evidence, and is not computed */
#define SHARP 0.22f        /* the rim of a shadow is softer than this change of the light's logarithm in 3 pixels */
#define MIN_LIGHT 0.02f    /* least light, as a factor of the look */
#define WEAK 0.5f          /* a pixel that differs by a larger share of what is allowed tells nothing about noise */
#define LIGHT_CHANGE 0.1f  /* the look is learned where the light differs less from that on the whole wall */

/* Every SAMPLE_PX-th pixel is a sample of the light on the whole wall. Those that are darker than the share BRIGHT of
   the percentile BRIGHT_PERCENT do not count: a glare changes black by a large factor. At least MIN_SAMPLE of all must
   be free to show the light. */
#define SAMPLE_PX 8
#define BRIGHT 0.3f
#define BRIGHT_PERCENT 90
#define MIN_SAMPLE 0.05f
/* If at least MIN_ALIKE of the samples have the color of the light before, up to ANOTHER_TINT, the others do not count:
   a person in a red shirt has just come. */
#define MIN_ALIKE 0.2f
#define ANOTHER_TINT 0.2f
#define UNSHADED_PERCENT 90  /* this percentile of the light at all samples is that outside of shadows */

/* What unit5_compare_wall finds out about each pixel: planes of floats, one after the other. */
enum { GRAY, WALL_GRAY, LIGHT, ERROR, EXCESS, STEP, NOISE, RIM, PLANES };
const int unit5_plane_count = PLANES;

static inline float mean3(float one, float two, float three) { return (one + two + three) / 3; }

/* Pixels are compared in runs, channel by channel, so that compilers can vectorize it. */
#define RUN 64
typedef struct { float channels[3][RUN]; } Run;

static inline void split_floats(const float *restrict pixels, int length, Run *restrict run)
{
    for (int x = 0; x < length; x++) {
        run->channels[0][x] = pixels[3 * x];
        run->channels[1][x] = pixels[3 * x + 1];
        run->channels[2][x] = pixels[3 * x + 2];
    }
}

static inline void split_bytes(const uint8_t *restrict pixels, int length, Run *restrict run)
{
    float floats[3 * RUN];
    for (int number = 0; number < 3 * length; number++)
        floats[number] = pixels[number];
    split_floats(floats, length, run);
}

/* The part of unit5_compare_wall that looks at a pixel alone, for at most RUN pixels. */
FAST static void compare_run(const uint8_t *seen_bytes, const float *looks, const float whole[3],
                             const uint8_t *contrast_bytes, const float *restrict variance, int length, int64_t count,
                             float *restrict planes)
{
    Run seen, look, contrast;
    split_bytes(seen_bytes, length, &seen);
    split_floats(looks, length, &look);
    split_bytes(contrast_bytes, length, &contrast);
    float found[PLANES][RUN], share[RUN];
    for (int channel = 0; channel < 3; channel++)
        for (int x = 0; x < length; x++) {
            look.channels[channel][x] *= whole[channel];
            contrast.channels[channel][x] *= whole[channel];
        }
    for (int x = 0; x < length; x++) {
        float gray = mean3(seen.channels[0][x], seen.channels[1][x], seen.channels[2][x]);
        float wall_gray = larger(mean3(look.channels[0][x], look.channels[1][x], look.channels[2][x]), 1);
        found[GRAY][x] = gray;
        found[WALL_GRAY][x] = wall_gray;
        found[LIGHT][x] = gray / wall_gray;
        share[x] = SHARE + TINT * larger(1 - TINTED_FROM / found[LIGHT][x], 0);
        found[NOISE][x] = LEVELS + DEVIATIONS * sqrtf(variance[x]);
        found[RIM][x] =
            RIM_SHARE * mean3(contrast.channels[0][x], contrast.channels[1][x], contrast.channels[2][x]);
        found[ERROR][x] = found[EXCESS][x] = 0;
    }
    /* In each channel: how far a pixel is off the wall in this light, and as a share of what is allowed. */
    for (int channel = 0; channel < 3; channel++)
        for (int x = 0; x < length; x++) {
            float light = found[LIGHT][x], lit = look.channels[channel][x] * light;
            float off = fabsf(seen.channels[channel][x] - lit);
            float allowed = share[x] * lit + RIM_SHARE * contrast.channels[channel][x] * light + found[NOISE][x];
            found[ERROR][x] = larger(found[ERROR][x], off);
            found[EXCESS][x] = larger(found[EXCESS][x], off / allowed);
        }
    for (int plane = 0; plane < PLANES; plane++)
        if (plane != STEP)
            memcpy(planes + plane * count, found[plane], sizeof(float) * length);
}

/* The least and the most light around each pixel of a row, in the three rows that ``least`` and ``most`` stand for. */
FAST static void around_row(const float *restrict least, const float *restrict most, int width, float *restrict low,
                            float *restrict high)
{
    for (int end = 0; end < 2; end++) {  /* at the ends, there is a neighbor on one side only */
        int x = end ? width - 1 : 0, next = end ? x - (x > 0) : x + (x < width - 1);
        low[x] = larger(smaller(least[x], least[next]), MIN_LIGHT);
        high[x] = larger(most[x], most[next]);
    }
    for (int x = 1; x < width - 1; x++) {
        low[x] = larger(smaller(smaller(least[x - 1], least[x]), least[x + 1]), MIN_LIGHT);
        high[x] = larger(larger(most[x - 1], most[x]), most[x + 1]);
    }
}

/* The part of unit5_compare_wall that looks at a row and its neighbors, where the planes begin at the row. ``low``,
   ``high``: the least and the most light around each pixel; overwritten. */
FAST static void compare_row(const uint8_t *restrict usable, int width, int64_t count, float darkest, float lightest,
                             float *restrict low, float *restrict high, float *restrict planes, uint8_t *restrict front)
{
    const float *restrict lights = planes + LIGHT * count, *restrict excess = planes + EXCESS * count;
    const float *restrict noise = planes + NOISE * count, *restrict rim = planes + RIM * count;
    const float *restrict wall_gray = planes + WALL_GRAY * count;
    float *restrict step = planes + STEP * count;
    for (int x = 0; x < width; x++) {
        float slack = (noise[x] * 2 / 3 + rim[x]) / wall_gray[x], light = lights[x];
        front[x] = (excess[x] > 1) | (light < darkest - slack) | (light > lightest + slack);
        high[x] /= low[x];
        low[x] = 2 * slack / larger(light, 0.1f);
        step[x] = (high[x] - 1 - low[x]) / SHARP;  /* a logarithm is at most that */
    }
    for (int x = 0; x < width; x++) {
        if (step[x] > WEAK_STEP) {
            step[x] = (logf(high[x]) - low[x]) / SHARP;
            front[x] |= step[x] > 1;
        } else
            step[x] = 0;
    }
    for (int x = 0; x < width; x++)
        front[x] &= usable[x] != 0;
}

int unit5_compare_wall(const uint8_t *seen, const float *look, const float whole[3], const uint8_t *contrast,
                       const float *variance, const uint8_t *usable, int width, int height, float darkest,
                       float lightest, float *planes, uint8_t *front)
{
    int64_t count = (int64_t)width * height, done = 0;
    float *least = malloc(4 * sizeof(float) * width + 1), *most = least + width;  /* the light in three rows */
    if (!least)
        return 0;
    for (int y = 0; y < height; y++) {
        int64_t at = (int64_t)y * width;
        for (; done < count && done < at + 2 * (int64_t)width; done += RUN)  /* while they are in the cache */
            compare_run(seen + 3 * done, look + 3 * done, whole, contrast + 3 * done, variance + done,
                        count - done < RUN ? (int)(count - done) : RUN, count, planes + done);
        const float *row = planes + LIGHT * count + at;
        const float *upper = y > 0 ? row - width : row, *lower = y < height - 1 ? row + width : row;
        for (int x = 0; x < width; x++) {
            least[x] = smaller(smaller(upper[x], row[x]), lower[x]);
            most[x] = larger(larger(upper[x], row[x]), lower[x]);
        }
        float *low = least + 2 * (int64_t)width, *high = low + width;
        if (width > 0)
            around_row(least, most, width, low, high);
        compare_row(usable + at, width, count, darkest, lightest, low, high, planes + at, front + at);
    }
    free(least);
    return 1;
}

/* Learn at most RUN pixels. */
FAST static void learn_run(const uint8_t *restrict seen, const float back[3], const float *restrict light,
                           const float *restrict error, const float *restrict excess, const uint8_t *restrict wall,
                           const uint8_t *restrict certain, int length, float passed, float settle, float rate,
                           float variance_rate, float *restrict look, float *restrict variance, uint8_t *restrict known,
                           float *restrict seconds)
{
    float is_wall[RUN], is_certain[RUN], part[RUN], parts[3 * RUN], unlit[3 * RUN];
    for (int x = 0; x < length; x++) {
        is_wall[x] = wall[x] != 0;
        is_certain[x] = certain[x] != 0;
    }
    for (int x = 0; x < length; x++) {
        seconds[x] = smaller(seconds[x] + is_wall[x] * passed, settle);
        part[x] = is_certain[x] * (fabsf(light[x] - 1) < LIGHT_CHANGE ? rate : 0);
        float share = is_certain[x] * (excess[x] < WEAK ? variance_rate : 0);
        variance[x] += share > 0 ? share * (error[x] * error[x] - variance[x]) : 0;
    }
    for (int x = 0; x < length; x++)
        if (wall[x] && !known[x])
            part[x] = known[x] = 1;
    for (int x = 0; x < length; x++)
        for (int channel = 0; channel < 3; channel++) {
            parts[3 * x + channel] = part[x];
            unlit[3 * x + channel] = back[channel];
        }
    for (int number = 0; number < 3 * length; number++)
        look[number] += parts[number] * (seen[number] * unlit[number] - look[number]);
}

void unit5_learn_wall(const uint8_t *seen, const float whole[3], const float *planes, const uint8_t *wall,
                      const uint8_t *certain, int64_t count, float passed, float settle, float rate,
                      float variance_rate, float *look, float *variance, uint8_t *known, float *seconds)
{
    const float *light = planes + LIGHT * count, *error = planes + ERROR * count, *excess = planes + EXCESS * count;
    float back[3] = {1 / whole[0], 1 / whole[1], 1 / whole[2]};
    for (int64_t at = 0; at < count; at += RUN)
        learn_run(seen + 3 * at, back, light + at, error + at, excess + at, wall + at, certain + at,
                  count - at < RUN ? (int)(count - at) : RUN, passed, settle, rate, variance_rate, look + 3 * at,
                  variance + at, known + at, seconds + at);
}

/* The value that ``percent`` of values are below, by the selection of C. Hoare, 1961, which reorders them. */
static float quantile(float *values, int64_t count, int percent)
{
    int64_t place = (count - 1) * percent / 100, first = 0, last = count - 1;
    while (first < last) {
        float pivot = values[(first + last) / 2];
        int64_t up = first, down = last;
        while (up <= down) {
            while (values[up] < pivot)
                up++;
            while (pivot < values[down])
                down--;
            if (up <= down) {
                float other = values[up];
                values[up++] = values[down];
                values[down--] = other;
            }
        }
        if (place <= down)
            last = down;
        else if (place >= up)
            first = up;
        else
            break;
    }
    return values[place];
}

/* The light on a wall at samples: as factors of its blue, green and red. */
typedef struct { float *channels[3]; int64_t count; } Lights;

static void keep(Lights *lights, int64_t number)
{
    for (int channel = 0; channel < 3; channel++)
        lights->channels[channel][lights->count] = lights->channels[channel][number];
    lights->count++;
}

static float mean_light(const Lights *lights, int64_t number)
{
    return mean3(lights->channels[0][number], lights->channels[1][number], lights->channels[2][number]);
}

/* How much the color of the light at a sample differs from that of another light. */
static float tint_of(const Lights *lights, int64_t number, const float other[3])
{
    float off = 0, mean = larger(mean_light(lights, number), MIN_LIGHT);
    float other_mean = larger(mean3(other[0], other[1], other[2]), MIN_LIGHT);
    for (int channel = 0; channel < 3; channel++)
        off = larger(off, fabsf(lights->channels[channel][number] / mean / (other[channel] / other_mean) - 1));
    return off;
}

/* Keep the samples where the wall is bright. ``grays``: of the wall there. ``spare``: room for as many. */
static void keep_bright(Lights *lights, const float *grays, float *spare)
{
    int64_t count = lights->count;
    memcpy(spare, grays, count * sizeof *spare);
    float least = BRIGHT * quantile(spare, count, BRIGHT_PERCENT);
    lights->count = 0;
    for (int64_t number = 0; number < count; number++)
        if (grays[number] >= least)
            keep(lights, number);
}

/* Keep the samples whose light has nearly the color of another one, if these are enough. ``spare``: see keep_bright. */
static void keep_alike(Lights *lights, const float other[3], float *spare)
{
    int64_t count = lights->count, alike = 0;
    for (int64_t number = 0; number < count; number++) {
        spare[number] = tint_of(lights, number, other);
        alike += spare[number] < ANOTHER_TINT;
    }
    if (!(alike > MIN_ALIKE * count))
        return;
    lights->count = 0;
    for (int64_t number = 0; number < count; number++)
        if (spare[number] < ANOTHER_TINT)
            keep(lights, number);
}

int unit5_measure_light(const uint8_t *seen, const float *look, const uint8_t *usable, const uint8_t *front, int width,
                        int height, float light[3], float *unshaded)
{
    int64_t most = (int64_t)((width + SAMPLE_PX - 1) / SAMPLE_PX) * ((height + SAMPLE_PX - 1) / SAMPLE_PX);
    float *spare = malloc(5 * sizeof(float) * most + 1), *grays = spare + most;
    if (!spare)
        return 0;
    Lights lights = {{grays + most, grays + 2 * most, grays + 3 * most}, 0};
    for (int y = 0; y < height; y += SAMPLE_PX)
        for (int x = 0; x < width; x += SAMPLE_PX) {
            int64_t at = (int64_t)y * width + x;
            if (!usable[at] || front[at])
                continue;
            grays[lights.count] = look[3 * at] + look[3 * at + 1] + look[3 * at + 2];
            for (int channel = 0; channel < 3; channel++)
                lights.channels[channel][lights.count] = seen[3 * at + channel] / larger(look[3 * at + channel], 1);
            lights.count++;
        }
    *unshaded = -1;
    if (lights.count > MIN_SAMPLE * most) {
        keep_bright(&lights, grays, spare);
        keep_alike(&lights, light, spare);
        for (int64_t number = 0; number < lights.count; number++)
            spare[number] = mean_light(&lights, number);
        if (lights.count)
            *unshaded = quantile(spare, lights.count, UNSHADED_PERCENT);
        for (int channel = 0; channel < 3 && lights.count; channel++)
            light[channel] = larger(quantile(lights.channels[channel], lights.count, 50), MIN_LIGHT);
    }
    free(spare);
    return 1;
}

FAST static void light_run(const float *restrict look, const float *restrict factors, int length,
                           uint8_t *restrict wall)
{
    for (int number = 0; number < length; number++)
        wall[number] = (int)(within(look[number] * factors[number], 255) + 0.5f);
}

void unit5_light_wall(const float *look, const float whole[3], int64_t count, uint8_t *wall)
{
    float factors[3 * RUN];
    for (int number = 0; number < 3 * RUN; number++)
        factors[number] = whole[number % 3];
    for (int64_t at = 0; at < 3 * count; at += 3 * RUN)
        light_run(look + at, factors, 3 * count - at < 3 * RUN ? (int)(3 * count - at) : 3 * RUN, wall + at);
}
