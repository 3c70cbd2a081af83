/* Warping a picture where a mask is not black.

   A pixel of the result is the mean of what it covers of the picture: of one, two or four samples there, from a level
   of the picture that is halved so often, across and down, that nothing between the samples is skipped. This is
   decided for each block of the mask.

   Levels across and down are those of "ripmaps"; samples in different columns and rows are a "rotated grid". */
#include "unit5.h"
#include "sampling.h"
#include "vectors.h"

#define BLOCK_WIDTH 16
#define BLOCK_HEIGHT 8
#define SINGLE 1.2f      /* a pixel that covers no more pixels of the picture than this is sampled once, */
#define DOUBLE 2.2f      /* and twice if it covers no more of the level than this */
#define MAX_STEP 1e5f    /* longest step from one pixel to the next; no picture is as large */
#define LEVELS 24        /* a picture is halved less often than this */
#define MOST_SAMPLES 4

const int unit5_block_width = BLOCK_WIDTH, unit5_block_height = BLOCK_HEIGHT, unit5_levels = LEVELS;

/* Where samples are within a pixel, from its middle. No two are in the same column or row, so that a fine line that
   moves over the pixel is never between all, nor on all of them. */
static const Point TWO[] = {{-0.25f, -0.25f}, {0.25f, 0.25f}};
static const Point FOUR[] = {{-0.375f, -0.125f}, {0.125f, -0.375f}, {0.375f, 0.125f}, {-0.125f, 0.375f}};

/* The way from the mask to the picture. */
typedef struct { float h[9]; Positions positions; } Way;

static Way make_way(const double to_picture[9], const float *positions, int64_t row)
{
    Way way = {.positions = {positions, row}};
    for (int number = 0; number < 9; number++)
        way.h[number] = to_picture[number];
    return way;
}

/* The place in the picture of a pixel of the mask. */
static Point find_place(const Way *way, int column, int row)
{
    const float *h = way->h, *seen = way->positions.first ? position_of(&way->positions, column, row) : NULL;
    float x = seen ? seen[0] : column, y = seen ? seen[1] : row, scale = 1 / (h[6] * x + h[7] * y + h[8]);
    return (Point){(h[0] * x + h[1] * y + h[2]) * scale, (h[3] * x + h[4] * y + h[5]) * scale};
}

/* A block of the mask: what is shown of each row, from ``begin`` to before ``end``, and a pixel in its middle. */
typedef struct { int top, rows, begin[BLOCK_HEIGHT], end[BLOCK_HEIGHT], x, y, is_empty; } Block;

static Block find_block(const Image *mask, int left, int top)
{
    int right = left + BLOCK_WIDTH < mask->width ? left + BLOCK_WIDTH : mask->width, first = BLOCK_HEIGHT, last = 0;
    Block block = {.top = top, .rows = top + BLOCK_HEIGHT < mask->height ? BLOCK_HEIGHT : mask->height - top};
    for (int row = 0; row < block.rows; row++) {
        const uint8_t *shown = mask->pixels + mask->row * (top + row);
        int begin = left, end = right;
        while (begin < end && !shown[mask->channels * begin])
            begin++;
        while (begin < end && !shown[mask->channels * (end - 1)])
            end--;
        block.begin[row] = begin;
        block.end[row] = end;
        if (begin < end) {
            first = row < first ? row : first;
            last = row;
        }
    }
    block.is_empty = first == BLOCK_HEIGHT;
    int middle = block.is_empty ? 0 : (first + last) / 2;
    block.x = (block.begin[middle] + block.end[middle]) / 2;
    block.x = block.x < mask->width ? block.x : mask->width - 1;
    block.y = top + middle;
    return block;
}

/* How a block is sampled. ``level_u``, ``level_v``: how often the level's picture is halved, across and down.
   ``u``, ``v``: how far the samples are from the middle of what a pixel covers, in pixels of the picture. */
typedef struct { int level_u, level_v, count; float u[MOST_SAMPLES], v[MOST_SAMPLES]; } Filter;

/* How often a picture is halved, along a side, for pixels that cover ``covered`` of its pixels along that side. One
   pixel of the level is then 0.32 to 0.64 of that. No side gets shorter than two pixels. */
static int level_of(float covered, int side)
{
    int level = 0;
    for (float length = 0.637f * covered; length >= 2 && side >> (level + 1) >= 2 && level + 1 < LEVELS; level++)
        length /= 2;
    return level;
}

static Filter find_filter(const Way *way, const Block *block, const Image *mask, int width, int height)
{
    /* A neighbor on the other side will do as well; a mask of a single row or column has none. */
    int next = block->x + 1 < mask->width ? block->x + 1 : block->x - (block->x > 0);
    int below = block->y + 1 < mask->height ? block->y + 1 : block->y - (block->y > 0);
    Point at = find_place(way, block->x, block->y);
    Point right = minus(find_place(way, next, block->y), at);
    Point down = minus(find_place(way, block->x, below), at);
    float covered_u = hypotf(right.x, down.x), covered_v = hypotf(right.y, down.y);
    float longer = larger(covered_u, covered_v);
    Filter filter = {.count = 1};
    if (!(longer > SINGLE && longer < MAX_STEP))  /* also if it is not a number, beyond the wall's horizon */
        return filter;
    filter.level_u = level_of(covered_u, width);
    filter.level_v = level_of(covered_v, height);
    longer = larger(covered_u / (1 << filter.level_u), covered_v / (1 << filter.level_v));
    filter.count = longer > DOUBLE ? 4 : 2;
    for (int sample = 0; sample < filter.count; sample++) {
        Point from = (filter.count == 4 ? FOUR : TWO)[sample];
        filter.u[sample] = from.x * right.x + from.y * down.x;
        filter.v[sample] = from.x * right.y + from.y * down.y;
    }
    return filter;
}

void unit5_find_levels(const Image *mask, int width, int height, const double to_picture[9], const float *positions,
                       int64_t row, uint16_t *levels)
{
    Way way = make_way(to_picture, positions, row);
    for (int top = 0; top < mask->height; top += BLOCK_HEIGHT)
        for (int left = 0; left < mask->width; left += BLOCK_WIDTH) {
            Block block = find_block(mask, left, top);
            Filter filter = find_filter(&way, &block, mask, width, height);
            *levels++ = block.is_empty ? LEVELS * LEVELS : LEVELS * filter.level_u + filter.level_v;
        }
}

/* Change a filter, and a homography to the picture, to steps in the level, from the middle of its first pixel. */
static void to_level(Filter *filter, const float to_picture[9], float h[9])
{
    float scale_u = STEPS / (float)(1 << filter->level_u), scale_v = STEPS / (float)(1 << filter->level_v);
    for (int number = 0; number < 9; number++)
        h[number] = to_picture[number] * (number < 3 ? scale_u : number < 6 ? scale_v : 1);
    for (int sample = 0; sample < filter->count; sample++) {
        /* The middle of the level's first pixel is that of several of the picture's. Half a step rounds. */
        filter->u[sample] = (filter->u[sample] + 0.5f) * scale_u + (0.5f - STEPS / 2);
        filter->v[sample] = (filter->v[sample] + 0.5f) * scale_v + (0.5f - STEPS / 2);
    }
}

/* Where some pixels are sampled: the byte of the level, and the weights for the steps from that pixel, in bytes too. */
typedef struct { int byte[BLOCK_WIDTH], x[BLOCK_WIDTH], y[BLOCK_WIDTH]; } Samples;

/* Colors were multiplied by their alpha. */
static void divide_by_alpha(uint8_t pixel[4])
{
    for (int color = 0; color < 3 && pixel[3] > 0 && pixel[3] < 255; color++) {
        int divided = (255 * pixel[color] + pixel[3] / 2) / pixel[3];
        pixel[color] = divided < 255 ? divided : 255;
    }
}

/* Set ``length`` pixels to the mean of ``count`` samples of each. ``bytes``: see load_pair. */
INLINE void mix_samples(uint8_t *pixel, int length, const Image *level, int channels, const Samples *samples,
                        int count, int bytes, const Weights *weights)
{
    for (int x = 0; x < length; x++, pixel += channels) {
        Pair sum = {0};
        for (int sample = 0; sample < count; sample++) {
            const Samples *at = samples + sample;
            sum += sample_pair(level->pixels + at->byte[x], level->row, bytes, weights, at->x[x], at->y[x]);
        }
        put_mean(pixel, sum, channels, count == 4 ? 8 : count == 2 ? 7 : 6);
        if (channels == 4)
            divide_by_alpha(pixel);
    }
}

/* Warp ``length`` pixels. ``u``, ``v``: where their middles are, in steps; see to_level. */
INLINE void warp_run(uint8_t *pixels, int length, const Image *level, int channels, const float u[BLOCK_WIDTH],
                     const float v[BLOCK_WIDTH], const Filter *filter, int count, const Weights *weights)
{
    float last_u = STEPS * (level->width - 1) - 1, last_v = STEPS * (level->height - 1) - 1;
    int lowest = STEPS * (level->height - 2) - 1, is_low = 0, row = level->row;
    Samples samples[MOST_SAMPLES];
    for (int sample = 0; sample < count; sample++)
        for (int x = 0; x < BLOCK_WIDTH; x++) {
            int at_u = (int)within(u[x] + filter->u[sample], last_u);
            int at_v = (int)within(v[x] + filter->v[sample], last_v);
            samples[sample].byte[x] = (at_v >> STEP_BITS) * row + (at_u >> STEP_BITS) * channels;
            samples[sample].x[x] = (at_u & (STEPS - 1)) * (int)sizeof(Pair);
            samples[sample].y[x] = (at_v & (STEPS - 1)) * (int)sizeof(Pair);
            is_low |= lowest - at_v;  /* negative in the last row, where nothing may be read behind the end */
        }
    if (is_low < 0)
        mix_samples(pixels, length, level, channels, samples, count, 2 * channels, weights);
    else
        mix_samples(pixels, length, level, channels, samples, count, 8, weights);
}

/* Warp what is shown of a block. ``h``: from the mask to steps in the level. */
INLINE void warp_block(const Image *warped, const Image *level, int channels, const Block *block,
                       const float h[9], const Positions *positions, const Filter *filter,
                       const Weights *weights)
{
    for (int row = 0; row < block->rows; row++) {
        int y = block->top + row, begin = block->begin[row], length = block->end[row] - begin;
        if (length <= 0)
            continue;
        float column[BLOCK_WIDTH], line[BLOCK_WIDTH], u[BLOCK_WIDTH], v[BLOCK_WIDTH];
        for (int x = 0; x < BLOCK_WIDTH; x++) {  /* also what is not shown, since compilers can vectorize it then */
            const float *seen = positions->first ? position_of(positions, begin + (x < length ? x : 0), y) : NULL;
            column[x] = seen ? seen[0] : begin + x;
            line[x] = seen ? seen[1] : y;
        }
        for (int x = 0; x < BLOCK_WIDTH; x++) {
            float scale = 1 / (h[6] * column[x] + h[7] * line[x] + h[8]);
            u[x] = (h[0] * column[x] + h[1] * line[x] + h[2]) * scale;
            v[x] = (h[3] * column[x] + h[4] * line[x] + h[5]) * scale;
        }
        uint8_t *pixels = warped->pixels + warped->row * y + channels * begin;
        if (filter->count == 4)
            warp_run(pixels, length, level, channels, u, v, filter, 4, weights);
        else if (filter->count == 2)
            warp_run(pixels, length, level, channels, u, v, filter, 2, weights);
        else
            warp_run(pixels, length, level, channels, u, v, filter, 1, weights);
    }
}

/* The same, for pictures with and without alpha. */
FAST static void warp_shown(const Image *warped, const Image *level, const Block *block, const float h[9],
                            const Positions *positions, const Filter *filter, const Weights *weights)
{
    if (warped->channels == 4)  /* compilers make faster code if they know the number */
        warp_block(warped, level, 4, block, h, positions, filter, weights);
    else
        warp_block(warped, level, 3, block, h, positions, filter, weights);
}

void unit5_warp_picture(const Image *warped, const Image *mask, int width, int height, const Image *levels,
                        const uint16_t *blocks, const double to_picture[9], const float *positions, int64_t row)
{
    Way way = make_way(to_picture, positions, row);
    Weights weights;
    find_weights(&weights, warped->channels);
    for (int top = 0; top < mask->height; top += BLOCK_HEIGHT)
        for (int left = 0; left < mask->width; left += BLOCK_WIDTH) {
            int number = *blocks++;
            if (number == LEVELS * LEVELS)
                continue;
            Block block = find_block(mask, left, top);
            Filter filter = find_filter(&way, &block, mask, width, height);
            float h[9];
            to_level(&filter, way.h, h);
            warp_shown(warped, levels + number, &block, h, &way.positions, &filter, &weights);
        }
}
