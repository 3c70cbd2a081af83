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

/* The gray at a point, interpolated linearly; outside of the frame, that of the nearest pixel. */
static inline float gray_at(const Frame *frame, Point at)
{
    float x = within(at.x, frame->width - 1), y = within(at.y, frame->height - 1);
    int left = (int)x, top = (int)y;
    int right = left + 1 < frame->width ? frame->channels : 0;
    int64_t down = top + 1 < frame->height ? frame->row : 0;
    const uint8_t *upper = frame->pixels + top * frame->row + left * frame->channels, *lower = upper + down;
    x -= left;
    y -= top;
    float weights[4] = {(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y};
#define MEAN(channel) (weights[0] * upper[channel] + weights[1] * upper[right + channel] \
                       + weights[2] * lower[channel] + weights[3] * lower[right + channel])
    return frame->channels == 1 ? MEAN(0) : 0.114f * MEAN(0) + 0.587f * MEAN(1) + 0.299f * MEAN(2);
#undef MEAN
}
