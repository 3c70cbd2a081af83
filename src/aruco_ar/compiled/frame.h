/* Points, frames, and the gray at a point of a frame. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#define MIN_CONTRAST 12   /* least difference between black and white, in gray levels; less is noise */
#define MAX_BEYOND 0.25f  /* a profile is clipped where it is beyond its ends by more than this share of the contrast */

typedef struct { float x, y; } Point;
typedef struct { const uint8_t *pixels; int64_t row; int width, height, channels; } Frame;

static inline Point plus(Point a, float times, Point b) { return (Point){a.x + times * b.x, a.y + times * b.y}; }
static inline Point minus(Point a, Point b) { return plus(a, -1, b); }
static inline float cross(Point a, Point b) { return a.x * b.y - a.y * b.x; }
static inline float length(Point a) { return sqrtf(a.x * a.x + a.y * a.y); }

static inline float larger(float a, float b) { return a > b ? a : b; }
static inline float smaller(float a, float b) { return a < b ? a : b; }
/* The value, limited to 0 to most; 0 if it is not a number. */
static inline float within(float value, float most) { return smaller(larger(value, 0), most); }

/* The gray between a pixel and the ones right of it and below, interpolated linearly. ``x``, ``y``: the distance from
   the pixel. ``right``, ``down``: the bytes to the others. */
static inline float gray_between(const uint8_t *upper, int right, int64_t down, int channels, float x, float y)
{
    const uint8_t *lower = upper + down;
    float weights[4] = {(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y};
#define MEAN(gray) (weights[0] * gray(upper) + weights[1] * gray(upper + right) \
                    + weights[2] * gray(lower) + weights[3] * gray(lower + right))
#define ONLY(pixel) *(pixel)
#define OF_BGR(pixel) (1868 * (pixel)[0] + 9617 * (pixel)[1] + 4899 * (pixel)[2])  /* integers are faster */
    return channels == 1 ? MEAN(ONLY) : MEAN(OF_BGR) / 16384;
#undef MEAN
#undef ONLY
#undef OF_BGR
}

/* The gray at a point; outside of the frame, that of the nearest pixel. */
static inline float gray_at(const Frame *frame, Point at)
{
    float x = within(at.x, frame->width - 1), y = within(at.y, frame->height - 1);
    int left = (int)x, top = (int)y;
    int right = left + 1 < frame->width ? frame->channels : 0;
    int64_t down = top + 1 < frame->height ? frame->row : 0;
    const uint8_t *pixel = frame->pixels + top * frame->row + left * frame->channels;
    return gray_between(pixel, right, down, frame->channels, x - left, y - top);
}

/* Whether there are pixels on all sides of a point. */
static inline int is_inside(const Frame *frame, Point at)
{
    return at.x >= 0 && at.y >= 0 && at.x < frame->width - 1 && at.y < frame->height - 1;
}

/* The gray at points on a line from one point to another, both included. */
static inline void gray_along(const Frame *frame, Point from, Point to, int count, float *gray)
{
    Point step = minus(to, from);
    step = (Point){step.x / (count - 1), step.y / (count - 1)};
    if (is_inside(frame, from) && is_inside(frame, plus(from, count - 1, step))) {  /* the usual case, which is faster */
        int channels = frame->channels;
        for (int i = 0; i < count; i++) {
            Point at = plus(from, i, step);
            int left = (int)at.x, top = (int)at.y;
            gray[i] = gray_between(frame->pixels + top * frame->row + left * channels, channels, frame->row, channels,
                                   at.x - left, at.y - top);
        }
    } else
        for (int i = 0; i < count; i++)
            gray[i] = gray_at(frame, plus(from, i, step));
}
