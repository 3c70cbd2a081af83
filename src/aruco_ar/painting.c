/* A picture painted into an area of a frame: called by paint.py.

   Only the pixels that the area covers are touched, each of them once. OpenCV warps the whole rectangle around the
   area, and what lies inside has then to be cut out and copied: about twice the time. */
#include "frame.h"

/* The frame is gone through in tiles of this size: what a tile shows of the picture is near in memory, however the
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

typedef struct { Frame picture; float to_picture[9]; Side sides[4]; float opacity; } Work;

/* Paint the pixels of a row from ``begin`` to ``end``, at most WIDE of them, those ``inside`` without mixing. */
static void paint_run(const Work *work, uint8_t *row, int y, int begin, int end, Span inside)
{
    const Frame *picture = &work->picture;
    const float *h = work->to_picture;
    float u0 = h[1] * y + h[2], v0 = h[4] * y + h[5], w0 = h[7] * y + h[8];
    float right = picture->width - 1, foot = picture->height - 1;
    int u[WIDE], v[WIDE], solid = picture->channels == 3 && work->opacity == 1;
    for (int x = begin; x < end; x++) {  /* by itself, since compilers do four at once */
        float scale = 1 / (h[6] * x + w0);
        u[x - begin] = (int)(PARTS * within((h[0] * x + u0) * scale, right) + 0.5f);
        v[x - begin] = (int)(PARTS * within((h[3] * x + v0) * scale, foot) + 0.5f);
    }
    for (int x = begin; x < end; x++) {
        int is_inside = inside.first <= x && x <= inside.last;
        if (is_inside && solid)
            paint_pixel(row + 3 * x, picture, u[x - begin], v[x - begin]);
        else
            mix_pixel(row + 3 * x, picture, u[x - begin], v[x - begin],
                      work->opacity * (is_inside ? 1 : cover_of(work->sides, x, y)));
    }
}

/* pixels, painted: of the frame, BGR, and of the picture, BGR perhaps with alpha, which has ``channels``; row: bytes
   from one row to the next. to_picture: the homography from the frame to the picture. corners: of the area.
   opacity: 0 to 1. Beyond its own edges the picture is as at its edges. */
void paint(uint8_t *pixels, int64_t row, int width, int height, const uint8_t *painted, int64_t painted_row,
           int painted_width, int painted_height, int channels, const double to_picture[9],
           const double corners[4][2], float opacity)
{
    Work work = {.picture = {painted, painted_row, painted_width, painted_height, channels}, .opacity = opacity};
    for (int number = 0; number < 9; number++)
        work.to_picture[number] = to_picture[number];
    find_sides(corners, work.sides);
    for (int top = 0; top < height; top += HIGH) {
        int high = height - top < HIGH ? height - top : HIGH;
        Span some[HIGH], inside[HIGH], all = {width, -1};
        for (int line = 0; line < high; line++) {
            some[line] = find_span(work.sides, top + line, 0, width);
            inside[line] = find_span(work.sides, top + line, 1, width);
            if (some[line].first <= some[line].last) {
                all.first = some[line].first < all.first ? some[line].first : all.first;
                all.last = some[line].last > all.last ? some[line].last : all.last;
            }
        }
        for (int left = all.first; left <= all.last; left += WIDE)
            for (int line = 0; line < high; line++) {
                int begin = some[line].first > left ? some[line].first : left;
                int end = some[line].last < left + WIDE ? some[line].last + 1 : left + WIDE;
                paint_run(&work, pixels + (top + line) * row, top + line, begin, end, inside[line]);
            }
    }
}
