/* A picture painted into an area of a frame: called by paint.py.

   Each row of the area is gone through once, and only the pixels that the area covers are touched. OpenCV warps
   the whole rectangle around the area, and what lies inside has then to be cut out and copied: about twice the time. */
#include "frame.h"

#define RUN 64      /* pixels whose places on the picture are worked out together, which compilers do four at once */
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

/* The first and the last pixel of a row whose cover is not below ``least``, within 0 and width - 1. */
static void find_span(const Side sides[4], int y, double least, int width, int *first, int *last)
{
    double from = 0, to = width - 1;
    for (int side = 0; side < 4; side++) {
        double right = sides[side].right, rest = sides[side].down * y + sides[side].rest - least;
        if (fabs(right) > 1e-9)
            *(right > 0 ? &from : &to) = right > 0 ? fmax(from, -rest / right) : fmin(to, -rest / right);
        else if (rest < 0)
            to = -1;
    }
    *first = (int)ceil(fmin(from, width));
    *last = (int)floor(fmax(to, -1));
}

/* Of a place on the picture: the pixels around it, and their weights, which are PARTS * PARTS together. */
#define AROUND(picture, u, v) \
    int left = u / PARTS, top = v / PARTS, x = u % PARTS, y = v % PARTS; \
    const uint8_t *here = picture->pixels + top * picture->row + left * picture->channels; \
    const uint8_t *next = here + (left + 1 < picture->width ? picture->channels : 0); \
    int64_t down = top + 1 < picture->height ? picture->row : 0; \
    int weights[4] = {(PARTS - x) * (PARTS - y), x * (PARTS - y), (PARTS - x) * y, x * y}; \
    const uint8_t *around[4] = {here, next, here + down, next + down}

/* The picture's color, linear between its pixels. */
static inline void paint_pixel(uint8_t *pixel, const Frame *picture, unsigned u, unsigned v)
{
    AROUND(picture, u, v);
    for (int color = 0; color < 3; color++) {
        int sum = PARTS * PARTS / 2;
        for (int corner = 0; corner < 4; corner++)
            sum += weights[corner] * around[corner][color];
        pixel[color] = sum / (PARTS * PARTS);
    }
}

/* The same mixed with what is there, as far as the picture covers it and, by its alpha, is to be seen. */
static void mix_pixel(uint8_t *pixel, const Frame *picture, unsigned u, unsigned v, float cover)
{
    AROUND(picture, u, v);
    float left_of_frame = 1, sums[3] = {0, 0, 0};
    for (int corner = 0; corner < 4; corner++) {
        float weight = cover * weights[corner] / (PARTS * PARTS);
        if (picture->channels == 4)  /* or colors that nobody sees would bleed in */
            weight *= around[corner][3] / 255.0f;
        left_of_frame -= weight;
        for (int color = 0; color < 3; color++)
            sums[color] += weight * around[corner][color];
    }
    for (int color = 0; color < 3; color++)
        pixel[color] = within(left_of_frame * pixel[color] + sums[color] + 0.5f, 255);
}

/* frame, picture: BGR, the picture perhaps with alpha; ``row``: bytes from one row to the next.
   to_picture: the homography from pixels of the frame to those of the picture. corners: (4, 2) of the area.
   opacity: 0 to 1. Beyond its own edges the picture is as at its edges. */
void paint(uint8_t *pixels, int64_t row, int width, int height, const uint8_t *painted, int64_t painted_row,
           int painted_width, int painted_height, int channels, const double to_picture[9],
           const double corners[4][2], float opacity)
{
    Frame picture = {painted, painted_row, painted_width, painted_height, channels};
    Side sides[4];
    find_sides(corners, sides);
    int solid = channels == 3 && opacity == 1;
    for (int y = 0; y < height; y++) {
        int first, last, first_inside, last_inside;
        find_span(sides, y, 0, width, &first, &last);
        find_span(sides, y, 1, width, &first_inside, &last_inside);
        const double *h = to_picture;
        float u0 = h[1] * y + h[2], v0 = h[4] * y + h[5], w0 = h[7] * y + h[8];
        float right = painted_width - 1, foot = painted_height - 1;
        for (int begin = first; begin <= last; begin += RUN) {
            int count = last + 1 - begin < RUN ? last + 1 - begin : RUN, u[RUN], v[RUN];
            for (int number = 0; number < count; number++) {
                float x = begin + number, scale = 1 / ((float)h[6] * x + w0);
                u[number] = (int)(PARTS * within(((float)h[0] * x + u0) * scale, right) + 0.5f);
                v[number] = (int)(PARTS * within(((float)h[3] * x + v0) * scale, foot) + 0.5f);
            }
            uint8_t *pixel = pixels + y * row + 3 * begin;
            for (int number = 0; number < count; number++, pixel += 3) {
                int x = begin + number, inside = first_inside <= x && x <= last_inside;
                if (inside && solid)
                    paint_pixel(pixel, &picture, u[number], v[number]);
                else
                    mix_pixel(pixel, &picture, u[number], v[number], opacity * (inside ? 1 : cover_of(sides, x, y)));
            }
        }
    }
}
