/* What a frame shows right around tags, beyond their blur. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "algebra.h"
#include "sort.h"
#include "unit5.h"

#define PLACES 16              /* number of colors of a ring along each side */
#define STEPS 14
#define ALL (4 * PLACES)
#define MIDDLE 2               /* of the four sides */
/* The frame is looked at so far out from a side, at most, and the color inside is taken so far in, in its lengths. */
#define MAX_REACH 0.4
#define INSIDE 0.05
/* While the contrast to the inside rises by this share of it and by so many gray levels, the blur has not ended. */
#define RISE 0.03f
#define RISE_LEVELS 1.0f
/* Another thing begins where the contrast changes by more than this share and so many gray levels. */
#define OTHER 0.15f
#define OTHER_LEVELS 8.0f
/* The contrast beyond the blur differs from the usual one by less than this. */
#define SETTLED 0.02f
#define SETTLED_LEVELS 1.0f
#define DARK unit5_dark        /* see unit5.h */
#define DEPTH_PX 3.0f          /* a color of the ring is a mean over this depth */
/* Light changes a color of the ring by a factor between these, besides what it does to all, and the channels of a color
   by factors that differ by less than SAME_COLOR. */
#define DARKEST 0.45
#define LIGHTEST 2.2
#define SAME_COLOR 0.15
/* The usual colors are a running mean of about so many frames. If less of the ring than ENOUGH has them, and the tag is
   in sight, they are others now. */
#define USUAL_OF 15
#define ENOUGH 0.3

/* How far out from a side the frame is looked at, in pixels of the frame. */
static const float OFFSETS_PX[STEPS] = {0.5f, 1, 1.5f, 2, 2.5f, 3, 4, 5, 7, 9, 12, 16, 20, 26};
const int unit5_ring_places = PLACES;

/* What is beside a side of a quadrilateral, at each place and step: first inside, then farther and farther out.
   ``gray``: the middle one at each step. From ``first`` to before ``end`` is the ground. */
typedef struct {
    float colors[PLACES][STEPS + 1][3], gray[STEPS + 1], contrast[STEPS];
    uint8_t shown[PLACES][STEPS + 1];
    int first, end;
} Beside;

/* The corners of the unit square, and the directions out of its sides, clockwise. */
static const double SQUARE[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, OUTWARD[4][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};

void unit5_find_ways(int count, const double *quads, double *ways)
{
    for (int quad = 0; quad < count; quad++) {
        double to[9];
        square_to(quads + 8 * quad, to);
        for (int side = 0; side < 4; side++)
            for (int place = 0; place < PLACES; place++)
                for (int end = 0; end < 2; end++, ways += 2) {
                    double at[2], reach = end ? MAX_REACH : -INSIDE;
                    for (int axis = 0; axis < 2; axis++)
                        at[axis] = SQUARE[side][axis] + reach * OUTWARD[side][axis]
                                   + (place + 0.5) / PLACES * (SQUARE[(side + 1) % 4][axis] - SQUARE[side][axis]);
                    map_point(to, at[0], at[1], ways);
                }
    }
}

/* How far out from each side each step is, in lengths from it to the opposite one, at most MAX_REACH; and that length in
   pixels. */
static void find_offsets(const double quad[8], double offsets[4][STEPS], double across[4])
{
    double lengths[4];
    for (int side = 0; side < 4; side++) {
        const double *at = quad + 2 * side, *next = quad + 2 * ((side + 1) % 4);
        lengths[side] = sqrt((next[0] - at[0]) * (next[0] - at[0]) + (next[1] - at[1]) * (next[1] - at[1]));
    }
    for (int side = 0; side < 4; side++) {
        across[side] = fmax((lengths[(side + 1) % 4] + lengths[(side + 3) % 4]) / 2, 1);
        for (int step = 0; step < STEPS; step++)
            offsets[side][step] = fmin(OFFSETS_PX[step] / across[side], MAX_REACH);
    }
}

/* The color of a frame at a point; outside of it, that of the nearest pixel. Returns whether it shows the point. */
static int color_at(const Image *frame, double x, double y, float color[3])
{
    float at_x = within((float)x, frame->width - 1), at_y = within((float)y, frame->height - 1);
    int left = (int)at_x, top = (int)at_y;
    int right = left + 1 < frame->width ? 3 : 0;
    int64_t down = top + 1 < frame->height ? frame->row : 0;
    const uint8_t *pixel = frame->pixels + frame->row * top + 3 * left;
    for (int channel = 0; channel < 3; channel++, pixel++) {
        float upper = pixel[0] + (at_x - left) * (pixel[right] - pixel[0]);
        float lower = pixel[down] + (at_x - left) * (pixel[down + right] - pixel[down]);
        color[channel] = upper + (at_y - top) * (lower - upper);
    }
    return x >= 0 && y >= 0 && x <= frame->width - 1 && y <= frame->height - 1;
}

/* ``ways``: as in unit5_find_ways, for one side. ``offsets``: of its steps. */
static void read_side(const Image *frame, const double ways[PLACES][2][2], const double offsets[STEPS], Beside *side)
{
    for (int step = 0; step <= STEPS; step++) {
        float grays[PLACES];
        double part = step ? (offsets[step - 1] + INSIDE) / (MAX_REACH + INSIDE) : 0;
        for (int place = 0; place < PLACES; place++) {
            const double *inner = ways[place][0], *outer = ways[place][1];
            float *color = side->colors[place][step];
            side->shown[place][step] = (uint8_t)color_at(frame, inner[0] + part * (outer[0] - inner[0]),
                                                         inner[1] + part * (outer[1] - inner[1]), color);
            grays[place] = (color[0] + color[1] + color[2]) / 3;
        }
        sort(grays, PLACES);
        side->gray[step] = grays[PLACES / 2];
    }
}

/* Find where the blur seems to end, and the ground. Close to the side, the contrast to the ``inside`` is less, because
   of the blur, and then it may be too much, since many cameras sharpen. Farther out, another thing may begin.
   ``count``: the number of steps to look at, at least 1. */
static void find_ground(Beside *side, float inside, int count)
{
    float *contrast = side->contrast, sorted[STEPS];
    for (int step = 0; step < STEPS; step++)
        contrast[step] = fabsf(side->gray[step + 1] - inside);
    int begin = 0;
    while (begin + 1 < count && contrast[begin + 1] - contrast[begin] >= larger(RISE * contrast[begin], RISE_LEVELS))
        begin++;
    int end = begin + 1;
    while (end < count && fabsf(contrast[end] - contrast[begin]) <= larger(OTHER * contrast[begin], OTHER_LEVELS))
        end++;
    end -= end < count && end - begin > 1;  /* the other thing is blurred, too */
    memcpy(sorted, contrast + begin, (end - begin) * sizeof *sorted);
    sort(sorted, end - begin);
    float usual = sorted[(end - begin - 1) / 2];
    side->first = begin;
    side->end = end;
    while (side->first + 1 < end
           && fabsf(contrast[side->first] - usual) > larger(SETTLED * usual, SETTLED_LEVELS))
        side->first++;
}

/* The mean color of the ground at each place, as far out as DEPTH_PX, and whether the frame shows all of that. */
static void find_colors(const Beside *side, double colors[PLACES][3], uint8_t shown[PLACES])
{
    int end = side->first + 1;
    while (end < side->end && OFFSETS_PX[end] - OFFSETS_PX[side->first] <= DEPTH_PX)
        end++;
    for (int place = 0; place < PLACES; place++) {
        float sum[3] = {0};
        shown[place] = 1;
        for (int step = side->first; step < end; step++) {
            shown[place] &= side->shown[place][step + 1];
            for (int channel = 0; channel < 3; channel++)
                sum[channel] += side->colors[place][step + 1][channel];
        }
        for (int channel = 0; channel < 3; channel++)
            colors[place][channel] = sum[channel] / (end - side->first);
    }
}

/* What is around a quadrilateral, grown by its blur: see unit5_read_rings. ``ends``: how far out the blur and the ground
   reach, in the units of ``offsets`` and ``across``, see find_offsets. */
static void grow(const double quad[8], const Beside sides[4], const double offsets[4][STEPS], const double across[4],
                 double corners[8], double reach_px[2])
{
    double to[9], reach[4];
    float blurs[4], depths[4];
    square_to(quad, to);
    for (int side = 0; side < 4; side++) {
        int first = sides[side].first, last = sides[side].end - 1;
        /* One step farther than the blur: on the very rim of a cover, a little of it would be seen as a thin line. */
        reach[side] = offsets[side][first + 1 < last ? first + 1 : last];
        blurs[side] = (float)(offsets[side][first] * across[side]);
        depths[side] = (float)(offsets[side][last] * across[side]);
    }
    for (int corner = 0; corner < 4; corner++) {
        double at[2];
        for (int axis = 0; axis < 2; axis++)
            at[axis] = SQUARE[corner][axis] + reach[corner] * OUTWARD[corner][axis]
                       + reach[(corner + 3) % 4] * OUTWARD[(corner + 3) % 4][axis];
        map_point(to, at[0], at[1], corners + 2 * corner);
    }
    sort(blurs, 4);
    sort(depths, 4);
    reach_px[0] = blurs[2];
    reach_px[1] = depths[1];
}

void unit5_read_rings(const Image *frame, int count, const double *quads, const double *ways, double *colors,
                      uint8_t *shown, double *corners, double *reaches)
{
    const double (*ways_of)[PLACES][2][2] = (const double (*)[PLACES][2][2])ways;
    double (*colors_of)[PLACES][3] = (double (*)[PLACES][3])colors;
    for (int quad = 0; quad < count; quad++) {
        Beside sides[4];
        double offsets[4][STEPS], across[4];
        float grays[4], firsts[4];
        find_offsets(quads + 8 * quad, offsets, across);
        for (int side = 0; side < 4; side++) {
            read_side(frame, ways_of[4 * quad + side], offsets[side], sides + side);
            grays[side] = sides[side].gray[0];
        }
        sort(grays, 4);
        for (int side = 0; side < 4; side++) {
            int steps = 1;  /* within MAX_REACH */
            while (steps < STEPS && offsets[side][steps] < MAX_REACH)
                steps++;
            find_ground(sides + side, grays[MIDDLE], steps);
            firsts[side] = (float)sides[side].first;
        }
        sort(firsts, 4);
        for (int side = 0; side < 4; side++) {
            Beside *here = sides + side;
            /* On rough ground, the blur may seem to end too early on a side. It hardly does so on two of the four. */
            int first = here->first < (int)firsts[1] ? (int)firsts[1] : here->first;
            here->first = first < here->end ? first : here->end - 1;
            find_colors(here, colors_of[4 * quad + side], shown + PLACES * (4 * quad + side));
        }
        grow(quads + 8 * quad, sides, (const double (*)[STEPS])offsets, across, corners + 8 * quad,
             reaches + 2 * quad);
    }
}

/* Whether light may change a color, BGR, by such factors. */
static int is_light(const double factors[3])
{
    double bright = (factors[0] + factors[1] + factors[2]) / 3, off = 0;
    for (int channel = 0; channel < 3; channel++)
        off = fmax(off, fabs(factors[channel] - bright));
    return bright > DARKEST && bright < LIGHTEST && off < SAME_COLOR * bright;
}

/* The factors by which light has changed most of a ring: the middle one of each channel where that is shown; of two, the
   larger one. 1 if nothing is shown. ``is_known``: whether the colors before are; then 1 if no light may do that: most of
   the ring is covered. */
static void find_common(const double changes[ALL][3], const uint8_t shown[ALL], int is_known, double common[3])
{
    for (int channel = 0; channel < 3; channel++) {
        float values[ALL];
        int count = 0;
        for (int place = 0; place < ALL; place++)
            if (shown[place])
                values[count++] = (float)changes[place][channel];
        sort(values, count);
        common[channel] = count ? values[count / 2 < count ? count / 2 : count - 1] : 1;
    }
    if (is_known && !is_light(common))
        common[0] = common[1] = common[2] = 1;
}

/* A ring's colors without those of other things: see unit5_even_rings. ``usual``: NULL if that is unknown. Returns the
   share of the ring that shows no other thing. */
static double even_ring(const double colors[ALL][3], const uint8_t shown[ALL], const double (*usual)[3],
                        double even[ALL][3])
{
    double changes[ALL][3], common[3];
    int usable[ALL], count = 0;
    for (int place = 0; place < ALL; place++)
        for (int channel = 0; channel < 3; channel++)
            changes[place][channel] = (colors[place][channel] + DARK) / ((usual ? usual[place][channel] : 1) + DARK);
    find_common((const double (*)[3])changes, shown, usual != NULL, common);
    for (int place = 0; place < ALL; place++) {
        double factors[3];
        for (int channel = 0; channel < 3; channel++)
            factors[channel] = changes[place][channel] / common[channel];
        count += usable[place] = shown[place] && is_light(factors);
    }
    for (int place = 0; place < ALL; place++) {
        memcpy(even[place], !count && usual ? usual[place] : colors[place], sizeof even[place]);
        if (usable[place] || !count)
            continue;
        double sum[3] = {0}, weights = 0;
        for (int other = 0; other < ALL; other++) {
            int away = abs(place - other), nearest = away < ALL - away ? away : ALL - away;
            double weight = usable[other] / (nearest * nearest + 0.5);
            weights += weight;
            for (int channel = 0; channel < 3; channel++)
                sum[channel] += weight * changes[other][channel];
        }
        for (int channel = 0; channel < 3; channel++)
            even[place][channel] = sum[channel] / weights * ((usual ? usual[place][channel] : 1) + DARK) - DARK;
    }
    return (double)count / ALL;
}

void unit5_even_rings(int count, const double *colors, const uint8_t *shown, const uint8_t *seen, double *usual,
                      double *even)
{
    for (int ring = 0; ring < count; ring++, shown += ALL) {
        const double (*now)[3] = (const double (*)[3])(colors + 3 * ALL * ring);
        double (*before)[3] = (double (*)[3])(usual + 3 * ALL * ring), (*evened)[3] = (double (*)[3])(even + 3 * ALL * ring);
        int is_known = !isnan(before[0][0]);
        double share = even_ring(now, shown, is_known ? (const double (*)[3])before : NULL, evened);
        if (seen[ring] && is_known && share < ENOUGH) {
            is_known = 0;
            even_ring(now, shown, NULL, evened);
        }
        for (int number = 0; seen[ring] && number < 3 * ALL; number++)
            before[0][number] = is_known ? before[0][number] + (evened[0][number] - before[0][number]) / USUAL_OF
                                         : evened[0][number];
    }
}
