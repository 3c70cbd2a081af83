/* Drawing the mask of an area. */
#include "unit5.h"

#define CLEARLY_PX 6   /* a pixel that is farther than this from all sides, in undistorted pixels, is not on the rim */
#define RUN 16         /* length of a run of pixels; its first and last one show whether all are in the area */

/* right * x + down * y + rest is the distance of a pixel from a side of the area, in pixels inward, plus a half. */
typedef struct { double right, down, rest; } Side;

static void find_sides(const double corners[4][2], Side sides[4])
{
    double area = 0;
    for (int side = 0; side < 4; side++) {
        const double *begin = corners[side], *end = corners[(side + 1) % 4];
        area += begin[0] * end[1] - begin[1] * end[0];
    }
    for (int side = 0; side < 4; side++) {
        const double *begin = corners[side], *end = corners[(side + 1) % 4];
        double x = end[0] - begin[0], y = end[1] - begin[1];
        double inward = fmax(hypot(x, y), 1e-9) * (area < 0 ? -1 : 1);
        sides[side] = (Side){-y / inward, x / inward, 0.5 + (y * begin[0] - x * begin[1]) / inward};
    }
}

/* The part of a pixel that the area covers: 1 if its middle is half a pixel or more inside of all sides, 0 if it is
   half a pixel or more outside of one, and linear between. */
static float cover_of(const Side sides[4], int x, int y)
{
    float cover = 1;
    for (int side = 0; side < 4; side++)
        cover = smaller(cover, sides[side].right * x + sides[side].down * y + sides[side].rest);
    return larger(cover, 0);
}

typedef struct { int first, last; } Span;  /* a span of pixels in a row */

/* The pixels of a row whose cover is at least ``least``, within 0 and width - 1. */
static Span find_span(const Side sides[4], int y, double least, int width)
{
    double from = 0, to = width - 1;
    for (int side = 0; side < 4; side++) {
        double right = sides[side].right, rest = sides[side].down * y + sides[side].rest - least;
        if (right > 1e-9)
            from = fmax(from, -rest / right);
        else if (right < -1e-9)
            to = fmin(to, -rest / right);
        else if (rest < 0)
            to = -1;
    }
    return (Span){(int)ceil(fmin(from, width)), (int)floor(fmax(to, -1))};
}

/* a * x + b * y + c is the undistorted distance of a position from a side of the area, inward. */
typedef struct { float a, b, c; } Line;

static inline float distance_from(Line side, const float *position)
{
    return side.a * position[0] + side.b * position[1] + side.c;
}

/* The part of a pixel that the area covers. ``here``, ``next`` and ``below``: the positions of the pixel and of two
   neighbors. Undistorted distances are divided by how much they grow from one pixel to the next. */
static float distorted_cover_of(const Line sides[4], const float *here, const float *next, const float *below)
{
    float cover = 1;
    for (int side = 0; side < 4; side++) {
        float distance = distance_from(sides[side], here);
        if (distance > CLEARLY_PX)
            continue;
        if (!(distance > -CLEARLY_PX))  /* so also if the lens does not see anything there */
            return 0;
        float to_next = distance_from(sides[side], next) - distance;
        float to_below = distance_from(sides[side], below) - distance;
        float square = larger(to_next * to_next + to_below * to_below, 1e-6f);
        if (4 * distance * distance >= square) {  /* half a pixel or more away; no root is needed */
            if (distance < 0)
                return 0;
            continue;
        }
        cover = smaller(cover, 0.5f + distance / sqrtf(square));
    }
    return larger(cover, 0);
}

/* Whether a run of pixels in a row is clearly inside of all sides, 1, or outside of one, -1; 0 if neither is clear.
   ``here``: the positions. The first and the last show it, since the distance hardly bends along a run. */
static int side_of_run(const Line sides[4], const float *here, int count)
{
    int is_inside = 1;
    for (int side = 0; side < 4; side++) {
        float first = distance_from(sides[side], here), last = distance_from(sides[side], here + 2 * (count - 1));
        if (first < -CLEARLY_PX && last < -CLEARLY_PX)
            return -1;
        is_inside &= first > CLEARLY_PX && last > CLEARLY_PX;
    }
    return is_inside;
}

static inline void set_pixel(uint8_t *pixel, int channels, uint8_t value)
{
    for (int channel = 0; channel < channels; channel++)
        pixel[channel] = value;
}

/* Draw an area into a mask of a distorted frame. ``channels``: of the mask. */
static inline void draw_distorted_mask(const Image *mask, int channels, const Side corners[4],
                                       const Positions *positions)
{
    int width = mask->width, height = mask->height;
    Line sides[4];
    for (int side = 0; side < 4; side++)
        sides[side] = (Line){corners[side].right, corners[side].down, corners[side].rest - 0.5};
    for (int y = 0; y < height; y++) {
        uint8_t *pixels = mask->pixels + mask->row * y;
        for (int left = 0; left < width; left += RUN) {
            int count = left + RUN < width ? RUN : width - left;
            const float *here = position_of(positions, left, y);
            const float *below = position_of(positions, left, y + 1 < height ? y + 1 : y - 1);
            int side = side_of_run(sides, here, count);
            if (side > 0)
                memset(pixels + channels * left, 255, channels * count);
            for (int x = 0; side == 0 && x < count; x++) {
                int next = left + x + 1 < width ? 2 * x + 2 : 2 * x - 2;
                float cover = distorted_cover_of(sides, here + 2 * x, here + next, below + 2 * x);
                set_pixel(pixels + channels * (left + x), channels, (int)(255 * cover + 0.5f));
            }
        }
    }
}

/* Draw the pixels of a row of a mask that the area may cover in part, from ``begin`` to before ``end``. */
static void draw_rim(uint8_t *pixels, int channels, const Side sides[4], int y, int begin, int end)
{
    for (int x = begin; x < end; x++)
        set_pixel(pixels + channels * x, channels, (int)(255 * cover_of(sides, x, y) + 0.5f));
}

void unit5_draw_mask(const Image *mask, const double corners[4][2], const float *positions, int64_t row)
{
    int width = mask->width, height = mask->height, channels = mask->channels;
    Side sides[4];
    find_sides(corners, sides);
    if (positions) {
        if (width > 1 && height > 1 && channels == 3)  /* compilers make faster code if they know the number */
            draw_distorted_mask(mask, 3, sides, &(Positions){positions, row});
        else if (width > 1 && height > 1)
            draw_distorted_mask(mask, channels, sides, &(Positions){positions, row});
        return;
    }
    for (int y = 0; y < height; y++) {
        uint8_t *pixels = mask->pixels + mask->row * y;
        Span some = find_span(sides, y, 0, width), whole = find_span(sides, y, 1, width);
        if (whole.first > whole.last)
            whole = (Span){some.last + 1, some.last};
        draw_rim(pixels, channels, sides, y, some.first, whole.first);
        memset(pixels + channels * whole.first, 255, channels * (whole.last + 1 - whole.first));
        draw_rim(pixels, channels, sides, y, whole.last + 1, some.last + 1);
    }
}
