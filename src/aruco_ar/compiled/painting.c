/* The mask of an area, and a picture warped to where the mask is not black: called by paint.py. */
#include "frame.h"

/* The mask is gone through in tiles of this size: what a tile shows of the picture is near in memory, however the
   picture is turned. */
#define WIDE 64
#define HIGH 32
#define PARTS 256   /* of a pixel of the picture, to which a place is rounded */

typedef struct { double right, down, rest; } Side;  /* right * x + down * y + rest: pixels inward, and a half */

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

/* How much of a pixel is in the area: half a pixel in, on, or half a pixel out of a side is all, half, or nothing. */
static float cover_of(const Side sides[4], int x, int y)
{
    float cover = 1;
    for (int side = 0; side < 4; side++)
        cover = smaller(cover, sides[side].right * x + sides[side].down * y + sides[side].rest);
    return larger(cover, 0);
}

typedef struct { int first, last; } Span;  /* of pixels in a row */

/* The pixels of a row whose cover is not below ``least``, within 0 and width - 1. */
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

/* mask: (height, width, 3), all black; it becomes white where the area with those corners is, and gray on its rim. */
void draw_mask(uint8_t *mask, int width, int height, const double corners[4][2])
{
    Side sides[4];
    find_sides(corners, sides);
    for (int y = 0; y < height; y++, mask += 3 * width) {
        Span some = find_span(sides, y, 0, width), whole = find_span(sides, y, 1, width);
        for (int x = some.first; x <= some.last; x++) {
            int is_whole = whole.first <= x && x <= whole.last;
            memset(mask + 3 * x, is_whole ? 255 : (int)(255 * cover_of(sides, x, y) + 0.5f), 3);
        }
    }
}

/* Of a place on the picture: the four pixels around it, and their weights, which are PARTS * PARTS together. */
#define AROUND(picture, u, v) \
    int left = u / PARTS, top = v / PARTS, x = u % PARTS, y = v % PARTS; \
    const uint8_t *here = picture->pixels + top * picture->row + left * picture->channels; \
    const uint8_t *next = here + (left + 1 < picture->width ? picture->channels : 0); \
    int64_t down = top + 1 < picture->height ? picture->row : 0; \
    int weights[4] = {(PARTS - x) * (PARTS - y), x * (PARTS - y), (PARTS - x) * y, x * y}; \
    const uint8_t *around[4] = {here, next, here + down, next + down}

/* The picture's color there, linear between its pixels. */
static inline void see(uint8_t *pixel, const Frame *picture, unsigned u, unsigned v)
{
    AROUND(picture, u, v);
    for (int color = 0; color < 3; color++) {
        int sum = PARTS * PARTS / 2;
        for (int corner = 0; corner < 4; corner++)
            sum += weights[corner] * around[corner][color];
        pixel[color] = sum / (PARTS * PARTS);
    }
}

/* The same with alpha: each color counts as much as it is to be seen, or colors that nobody sees would bleed in. */
static void see_alpha(uint8_t *pixel, const Frame *picture, unsigned u, unsigned v)
{
    AROUND(picture, u, v);
    float alpha = 0, sums[3] = {0, 0, 0};
    for (int corner = 0; corner < 4; corner++) {
        float weight = (float)weights[corner] * around[corner][3] / (PARTS * PARTS);
        alpha += weight;
        for (int color = 0; color < 3; color++)
            sums[color] += weight * around[corner][color];
    }
    for (int color = 0; color < 3; color++)
        pixel[color] = alpha > 0 ? within(sums[color] / alpha + 0.5f, 255) : 0;
    pixel[3] = within(alpha + 0.5f, 255);
}

/* The pixels of a row from ``begin`` to ``end``, at most WIDE of them. */
static void warp_run(uint8_t *row, const Frame *picture, const float h[9], int y, int begin, int end)
{
    float u0 = h[1] * y + h[2], v0 = h[4] * y + h[5], w0 = h[7] * y + h[8];
    float right = picture->width - 1, foot = picture->height - 1;
    int u[WIDE], v[WIDE], channels = picture->channels;
    for (int x = begin; x < end; x++) {  /* by itself, since compilers do four at once */
        float scale = 1 / (h[6] * x + w0);
        u[x - begin] = (int)(PARTS * within((h[0] * x + u0) * scale, right) + 0.5f);
        v[x - begin] = (int)(PARTS * within((h[3] * x + v0) * scale, foot) + 0.5f);
    }
    for (int x = begin; x < end; x++)
        (channels == 4 ? see_alpha : see)(row + channels * x, picture, u[x - begin], v[x - begin]);
}

/* warped: (height, width, channels), of which what the mask, (height, width, 3), shows is set. pixels: of the picture,
   BGR or BGRA, with ``row`` bytes from one row to the next. to_picture: the homography from the mask to the picture.
   Beyond its own edges the picture is as at its edges. */
void warp(uint8_t *warped, const uint8_t *mask, int width, int height, const uint8_t *pixels, int64_t row,
          int picture_width, int picture_height, int channels, const double to_picture[9])
{
    Frame picture = {pixels, row, picture_width, picture_height, channels};
    float h[9];
    for (int number = 0; number < 9; number++)
        h[number] = to_picture[number];
    for (int top = 0; top < height; top += HIGH)
        for (int left = 0; left < width; left += WIDE)
            for (int y = top; y < height && y < top + HIGH; y++) {
                const uint8_t *shown = mask + (int64_t)3 * width * y;
                int begin = left, end = left + WIDE < width ? left + WIDE : width;
                while (begin < end && !shown[3 * begin])
                    begin++;
                while (begin < end && !shown[3 * end - 3])
                    end--;
                warp_run(warped + (int64_t)channels * width * y, &picture, h, y, begin, end);
            }
}
