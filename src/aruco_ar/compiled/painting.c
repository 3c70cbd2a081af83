/* Drawing the mask of an area, and warping a picture where the mask is not black. */
#include "unit5.h"

/* Warping goes through the frame in tiles of this size. The pixels of the picture that a tile needs are near each
   other in memory, even if the picture is turned. */
#define TILE_WIDTH 64
#define TILE_HEIGHT 32
#define CLEARLY_PX 6   /* a pixel that is farther than this from all sides, in undistorted pixels, is not on the rim */
#define RUN 16         /* length of a run of pixels; its first and last one show whether all are in the area */
#define ONE_LEVEL 0.4f /* a level of the pyramid is used alone within this share of the way to the next */
#define FILTER_RUN 32  /* number of neighboring pixels of a row that are filtered alike */
#define SHARPER 0.15f  /* the level is lower by this than the one at which nothing at all would shimmer */
#define MAX_STEP 1e5f   /* longest step from one pixel to the next; no picture is as large */
#define MAX_PROBES 4   /* most samples along what a pixel covers of a picture on a slanted wall */
#define STEPS 256   /* positions in the picture are rounded to this many steps per pixel */

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

/* The undistorted positions, (x, y), of pixels, with ``row`` bytes from one row to the next; NULL without a lens. */
typedef struct { const float *first; int64_t row; } Positions;

static const float *position_of(const Positions *positions, int x, int y)
{
    return (const float *)((const char *)positions->first + positions->row * y) + 2 * x;
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
        cover = smaller(cover, 0.5f + distance / larger(length((Point){to_next, to_below}), 1e-3f));
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

/* Declares the four pixels around a position in the picture, and their weights, whose sum is STEPS * STEPS. */
#define DECLARE_NEIGHBORS(picture, u, v) \
    int left = u / STEPS, top = v / STEPS, x = u % STEPS, y = v % STEPS; \
    const uint8_t *here = picture->pixels + top * picture->row + left * picture->channels; \
    const uint8_t *next = here + (left + 1 < picture->width ? picture->channels : 0); \
    int64_t down = top + 1 < picture->height ? picture->row : 0; \
    int weights[4] = {(STEPS - x) * (STEPS - y), x * (STEPS - y), (STEPS - x) * y, x * y}; \
    const uint8_t *neighbors[4] = {here, next, here + down, next + down}

/* Set a pixel to the picture's color at a position, interpolated linearly. */
static inline void sample(uint8_t *pixel, const Image *picture, unsigned u, unsigned v)
{
    DECLARE_NEIGHBORS(picture, u, v);
    for (int color = 0; color < 3; color++) {
        int sum = STEPS * STEPS / 2;
        for (int corner = 0; corner < 4; corner++)
            sum += weights[corner] * neighbors[corner][color];
        pixel[color] = sum / (STEPS * STEPS);
    }
}

/* The same with alpha. Colors are weighted by their alpha, so that transparent ones do not bleed in. */
static void sample_alpha(uint8_t *pixel, const Image *picture, unsigned u, unsigned v)
{
    DECLARE_NEIGHBORS(picture, u, v);
    float alpha = 0, sums[3] = {0, 0, 0};
    for (int corner = 0; corner < 4; corner++) {
        float weight = (float)weights[corner] * neighbors[corner][3] / (STEPS * STEPS);
        alpha += weight;
        for (int color = 0; color < 3; color++)
            sums[color] += weight * neighbors[corner][color];
    }
    for (int color = 0; color < 3; color++)
        pixel[color] = alpha > 0 ? within(sums[color] / alpha + 0.5f, 255) : 0;
    pixel[3] = within(alpha + 0.5f, 255);
}

/* A position in the picture, u or v, as one in the picture halved ``number`` times, which has ``size`` pixels. */
static inline unsigned at_level(int position, int number, int size)
{
    int at = ((position + STEPS / 2) >> number) - STEPS / 2, last = STEPS * (size - 1);
    return at < 0 ? 0 : at > last ? last : at;
}

/* How the picture is filtered for some neighboring pixels: ``probes`` samples along (step_u, step_v), which is what one
   pixel covers, each a mean of two levels of the pyramid: ``low`` and, with the weight ``part``, the next. */
typedef struct { int step_u, step_v, probes, low; float part; } Filter;

/* (u, v) moves by (right_u, right_v) to the next pixel and by (down_u, down_v) to the pixel below. If the wall is
   slanted, one of the two is much longer. Then several probes along it are sharper than one at a higher level. */
static Filter find_filter(float right_u, float right_v, float down_u, float down_v, int levels)
{
    float right = hypotf(right_u, right_v), down = hypotf(down_u, down_v);
    float longer = larger(right, down), shorter = larger(smaller(right, down), 1);
    Filter filter = {0, 0, 1, 0, 0};
    if (!(longer > 1 && longer < MAX_STEP))  /* also if the position is not a number, beyond the wall's horizon */
        return filter;
    shorter = larger(shorter, longer / MAX_PROBES);
    filter.probes = (int)ceilf(longer / shorter - 0.35f);  /* one, if it is nearly as long as wide */
    float level = within(log2f(shorter) - SHARPER, levels - 1);
    filter.low = level < levels - 1 ? (int)level : levels - 1;
    /* Near a level, that alone is used, which takes half the time. */
    filter.part = within((level - filter.low - ONE_LEVEL) / (1 - 2 * ONE_LEVEL), 1);
    if (filter.part == 1)
        filter = (Filter){0, 0, filter.probes, filter.low + 1, 0};
    filter.step_u = (int)(STEPS * (right > down ? right_u : down_u));
    filter.step_v = (int)(STEPS * (right > down ? right_v : down_v));
    return filter;
}

/* Where a probe of a Filter is, u or v, around a position. ``step``: step_u or step_v. */
static inline int probe_at(int position, int step, int probe, const Filter *filter)
{
    return position + step * (2 * probe + 1 - filter->probes) / (2 * filter->probes);
}

/* Set a pixel to the mean of what it covers of the picture. */
static inline void sample_filtered(uint8_t *pixel, const Image *levels, const Filter *filter, int u, int v)
{
    int sums[3] = {0, 0, 0}, part = (int)(STEPS * filter->part);
    for (int probe = 0; probe < filter->probes; probe++) {
        int at_u = probe_at(u, filter->step_u, probe, filter), at_v = probe_at(v, filter->step_v, probe, filter);
        for (int next = 0; next <= (part > 0); next++) {
            const Image *level = levels + filter->low + next;
            uint8_t seen[3];
            sample(seen, level, at_level(at_u, filter->low + next, level->width),
                   at_level(at_v, filter->low + next, level->height));
            for (int color = 0; color < 3; color++)
                sums[color] += (next ? part : STEPS - part) * seen[color];
        }
    }
    for (int color = 0; color < 3; color++)
        pixel[color] = (sums[color] + filter->probes * STEPS / 2) / (filter->probes * STEPS);
}

/* The same with alpha. */
static void sample_filtered_alpha(uint8_t *pixel, const Image *levels, const Filter *filter, int u, int v)
{
    float sums[4] = {0, 0, 0, 0};
    for (int probe = 0; probe < filter->probes; probe++) {
        int at_u = probe_at(u, filter->step_u, probe, filter), at_v = probe_at(v, filter->step_v, probe, filter);
        for (int next = 0; next <= (filter->part > 0); next++) {
            const Image *level = levels + filter->low + next;
            uint8_t seen[4];
            sample_alpha(seen, level, at_level(at_u, filter->low + next, level->width),
                         at_level(at_v, filter->low + next, level->height));
            float weight = (next ? filter->part : 1 - filter->part) * seen[3];
            sums[3] += weight;
            for (int color = 0; color < 3; color++)
                sums[color] += weight * seen[color];
        }
    }
    for (int color = 0; color < 3; color++)
        pixel[color] = sums[3] > 0 ? within(sums[color] / sums[3] + 0.5f, 255) : 0;
    pixel[3] = within(sums[3] / filter->probes + 0.5f, 255);
}

/* The place in the picture of a pixel, in a column and a row. ``positions``: of the row, or NULL. */
static inline Point place_of(const float h[9], const float *positions, int column, int row)
{
    float x = positions ? positions[2 * column] : column, y = positions ? positions[2 * column + 1] : row;
    float scale = 1 / (h[6] * x + h[7] * y + h[8]);
    return (Point){(h[0] * x + h[1] * y + h[2]) * scale, (h[3] * x + h[4] * y + h[5]) * scale};
}

/* Warp the pixels of row y from ``begin`` to ``end``, which are at most TILE_WIDTH. ``neighbor``: the row below, or
   above the last row. */
static void warp_run(uint8_t *row, const Image *levels, int count, const float h[9], const Positions *positions, int y,
                     int neighbor, int begin, int end)
{
    float right = levels->width - 1, foot = levels->height - 1;
    int u[TILE_WIDTH], v[TILE_WIDTH], channels = levels->channels;
    const float *here = positions->first ? position_of(positions, 0, y) : NULL;
    const float *below = positions->first ? position_of(positions, 0, neighbor) : NULL;
    for (int x = begin; x < end; x++) {  /* a loop of its own, since compilers can vectorize it */
        Point at = place_of(h, here, x, y);
        u[x - begin] = (int)(STEPS * within(at.x, right) + 0.5f);
        v[x - begin] = (int)(STEPS * within(at.y, foot) + 0.5f);
    }
    for (int first = begin; first < end; first += FILTER_RUN) {
        int last = first + FILTER_RUN < end ? first + FILTER_RUN - 1 : end - 1, middle = (first + last) / 2;
        Point from = place_of(h, here, first, y), to = place_of(h, here, last, y);
        Point at = place_of(h, here, middle, y), next = place_of(h, below, middle, neighbor);
        float steps = last > first ? last - first : 1;
        Filter filter = find_filter((to.x - from.x) / steps, (to.y - from.y) / steps, next.x - at.x, next.y - at.y,
                                    count);
        if (filter.probes > 1 || filter.part > 0) {
            for (int x = first; x <= last; x++)
                (channels == 4 ? sample_filtered_alpha : sample_filtered)(row + channels * x, levels, &filter,
                                                                          u[x - begin], v[x - begin]);
            continue;
        }
        const Image *level = levels + filter.low;
        for (int x = first - begin; filter.low > 0 && x <= last - begin; x++) {
            u[x] = at_level(u[x], filter.low, level->width);
            v[x] = at_level(v[x], filter.low, level->height);
        }
        for (int x = first; x <= last; x++)
            (channels == 4 ? sample_alpha : sample)(row + channels * x, level, u[x - begin], v[x - begin]);
    }
}

void unit5_warp_picture(const Image *warped, const Image *mask, const Image *levels, int count,
                        const double to_picture[9], const float *positions, int64_t row)
{
    int width = mask->width, height = mask->height, shades = mask->channels;
    Positions all = {positions, row};
    float h[9];
    for (int number = 0; number < 9; number++)
        h[number] = to_picture[number];
    for (int top = 0; top < height; top += TILE_HEIGHT)
        for (int left = 0; left < width; left += TILE_WIDTH)
            for (int y = top; y < height && y < top + TILE_HEIGHT; y++) {
                const uint8_t *shown = mask->pixels + mask->row * y;
                int begin = left, end = left + TILE_WIDTH < width ? left + TILE_WIDTH : width;
                while (begin < end && !shown[shades * begin])
                    begin++;
                while (begin < end && !shown[shades * (end - 1)])
                    end--;
                warp_run(warped->pixels + warped->row * y, levels, count, h, &all, y,
                         y + 1 < height ? y + 1 : y > 0 ? y - 1 : y, begin, end);
            }
}
