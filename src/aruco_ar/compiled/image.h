/* Points, images, and the gray at a point of an image.

   The functions are in this header, so that compilers put them into the loops that call them: if the gray at a
   point took a call, tags would be compared 8 % slower, and fitted 2 % slower. */
#pragma once

#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct { float x, y; } Point;
/* ``row``: the bytes from one row of pixels to the next, which may be negative. */
typedef struct { uint8_t *pixels; int64_t row; int width, height, channels; } Image;
/* The undistorted positions of pixels, with ``row`` bytes from one row to the next; NULL without a lens. */
typedef struct { const float *first; int64_t row; } Positions;

static inline Point plus(Point a, float times, Point b) { return (Point){a.x + times * b.x, a.y + times * b.y}; }
static inline Point minus(Point a, Point b) { return plus(a, -1, b); }
static inline float cross(Point a, Point b) { return a.x * b.y - a.y * b.x; }
static inline float length(Point a) { return sqrtf(a.x * a.x + a.y * a.y); }

/* The undistorted position, x and y, of a pixel. */
static inline const float *position_of(const Positions *positions, int x, int y)
{
    return (const float *)((const char *)positions->first + positions->row * y) + 2 * x;
}

static inline float larger(float a, float b) { return a > b ? a : b; }
static inline float smaller(float a, float b) { return a < b ? a : b; }
/* The value, limited to 0 to most; 0 if it is not a number. */
static inline float within(float value, float most) { return smaller(larger(value, 0), most); }

/* The gray of a pixel, as an integer, which is faster; of BGR it is larger by the last factor. */
#define PIXEL_OF_GRAY(pixel) *(pixel)
#define PIXEL_OF_BGR(pixel) (1868 * (pixel)[0] + 9617 * (pixel)[1] + 4899 * (pixel)[2])
#define WHOLE_OF_BGR 16384

/* The gray between a pixel and the ones right of it and below, interpolated linearly. ``x``, ``y``: the distance from
   the pixel. ``right``, ``down``: the bytes to the others. */
static inline float gray_between(const uint8_t *upper, int right, int64_t down, int channels, float x, float y)
{
    const uint8_t *lower = upper + down;
    float weights[4] = {(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y};
#define MEAN(gray) (weights[0] * gray(upper) + weights[1] * gray(upper + right) \
                    + weights[2] * gray(lower) + weights[3] * gray(lower + right))
    return channels == 1 ? MEAN(PIXEL_OF_GRAY) : MEAN(PIXEL_OF_BGR) / WHOLE_OF_BGR;
#undef MEAN
}

/* The gray at a point; outside of the image, that of the nearest pixel. */
static inline float gray_at(const Image *image, Point at)
{
    float x = within(at.x, image->width - 1), y = within(at.y, image->height - 1);
    int left = (int)x, top = (int)y;
    int right = left + 1 < image->width ? image->channels : 0;
    int64_t down = top + 1 < image->height ? image->row : 0;
    const uint8_t *pixel = image->pixels + top * image->row + left * image->channels;
    return gray_between(pixel, right, down, image->channels, x - left, y - top);
}
