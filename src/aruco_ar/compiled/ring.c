/* What a frame shows right around tags, beyond their blur. */
#include "sort.h"
#include "unit5.h"

#define PLACES 16              /* number of colors of a ring along each side */
#define STEPS 14
#define MIDDLE 2               /* of the four sides */
/* While the contrast to the inside rises by this share of it and by so many gray levels, the blur has not ended. */
#define RISE 0.03f
#define RISE_LEVELS 1.0f
/* Another thing begins where the contrast changes by more than this share and so many gray levels. */
#define OTHER 0.15f
#define OTHER_LEVELS 8.0f
/* The contrast beyond the blur differs from the usual one by less than this. */
#define SETTLED 0.02f
#define SETTLED_LEVELS 1.0f
#define DEPTH_PX 3.0f          /* a color of the ring is a mean over this depth */

/* How far out from a side the frame is looked at, in pixels of the frame. */
const float unit5_ring_offsets[STEPS] = {0.5f, 1, 1.5f, 2, 2.5f, 3, 4, 5, 7, 9, 12, 16, 20, 26};
const int unit5_ring_steps = STEPS, unit5_ring_places = PLACES;

/* What is beside a side of a quadrilateral, at each place and step: first inside, then farther and farther out.
   ``gray``: the middle one at each step. From ``first`` to before ``end`` is the ground. */
typedef struct {
    float colors[PLACES][STEPS + 1][3], gray[STEPS + 1], contrast[STEPS];
    uint8_t shown[PLACES][STEPS + 1];
    int first, end;
} Beside;

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

/* The arguments are those of unit5_read_rings, for one side. */
static void read_side(const Image *frame, const double ends[PLACES][2][2], const double *parts, Beside *side)
{
    for (int step = 0; step <= STEPS; step++) {
        float grays[PLACES];
        for (int place = 0; place < PLACES; place++) {
            const double *inner = ends[place][0], *outer = ends[place][1];
            float *color = side->colors[place][step];
            side->shown[place][step] = (uint8_t)color_at(frame, inner[0] + parts[step] * (outer[0] - inner[0]),
                                                         inner[1] + parts[step] * (outer[1] - inner[1]), color);
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
    while (end < side->end && unit5_ring_offsets[end] - unit5_ring_offsets[side->first] <= DEPTH_PX)
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

void unit5_read_rings(const Image *frame, int count, const double *ends, const double *parts, const int *steps,
                      double *colors, uint8_t *shown, int *depths)
{
    const double (*ends_of)[PLACES][2][2] = (const double (*)[PLACES][2][2])ends;
    double (*colors_of)[PLACES][3] = (double (*)[PLACES][3])colors;
    for (int quad = 0; quad < count; quad++) {
        Beside sides[4];
        float grays[4], firsts[4];
        for (int side = 0; side < 4; side++) {
            read_side(frame, ends_of[4 * quad + side], parts + (STEPS + 1) * (4 * quad + side), sides + side);
            grays[side] = sides[side].gray[0];
        }
        sort(grays, 4);
        for (int side = 0; side < 4; side++) {
            find_ground(sides + side, grays[MIDDLE], steps[4 * quad + side]);
            firsts[side] = (float)sides[side].first;
        }
        sort(firsts, 4);
        for (int side = 0; side < 4; side++) {
            Beside *here = sides + side;
            /* On rough ground, the blur may seem to end too early on a side. It hardly does so on two of the four. */
            int first = here->first < (int)firsts[1] ? (int)firsts[1] : here->first;
            here->first = first < here->end ? first : here->end - 1;
            find_colors(here, colors_of[4 * quad + side], shown + PLACES * (4 * quad + side));
            depths[2 * (4 * quad + side)] = here->first;
            depths[2 * (4 * quad + side) + 1] = here->end - 1;
        }
    }
}
