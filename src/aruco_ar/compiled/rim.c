/* How much of each pixel the things in front of a wall cover: a pixel at a rim is a mixture.

   Sums in windows are integers, so that they slide over the image without an error. Beyond the image, it is mirrored. */
#include <stdlib.h>

#include "unit5.h"
#include "vectors.h"

#define CORE_REACH 4           /* what is in front by so many pixels on all sides has nothing of the wall */
#define INNER_REACH 2          /* what is so by this is no mixture, unless it is a shadow */
#define THING_REACH 8          /* the color of a thing is a mean over so many pixels on each side */
#define SHADE_REACH 7          /* so is the light on the wall beside it */
/* The light on the wall at the rim of a thing differs from that as if 1 were so many gray levels. A pixel inside is no
   thing if it is off a shadow by less than SHADOW_LEVELS, with less than SHADOW_SHARE of the thing. */
#define SHADE_LEVELS 50.0f
#define SHADOW_LEVELS 10.0f
#define SHADOW_SHARE 0.25f
#define MIN_CONTRAST 5.0f      /* gray levels between a thing and the wall that are needed to tell a pixel's share */
/* Without a core nearby, all that is in front tells the color of the thing. Weights of both. */
#define FRONT_WEIGHT 1
#define CORE_WEIGHT 100
#define GRAY_BITS 6            /* gray levels are integers in this fraction */
#define MOST_GRAY 4095

typedef int32_t Sums __attribute__((vector_size(16)));

/* What is known of each pixel. ``core`` and ``inner``: of the things. ``rim``: what may be a mixture. ``grays``: of the
   frame and of the wall, where nothing is in front; 0 elsewhere. */
typedef struct { const uint8_t *seen, *front; const float *wall; uint8_t *core, *inner, *rim; int32_t *grays[2]; } Pixels;

/* Grow a mask, whose values are 0 and 1, by ``reach`` pixels in all directions; if ``of`` is 1, what is not in it, which
   shrinks it. ``spare``: room for one mask. */
FAST static void grow(const uint8_t *restrict mask, uint8_t of, int reach, int width, int height,
                      uint8_t *restrict spare, uint8_t *restrict grown)
{
    int64_t count = (int64_t)width * height;
    for (int64_t at = 0; at < count; at++)
        spare[at] = grown[at] = mask[at] ^ of;
    for (int y = 0; y < height; y++)
        for (int off = 1; off <= reach && off < width; off++) {
            const uint8_t *restrict row = grown + (int64_t)width * y;
            uint8_t *restrict wide = spare + (int64_t)width * y;
            for (int x = 0; x < width - off; x++)
                wide[x] |= row[x + off];
            for (int x = off; x < width; x++)
                wide[x] |= row[x - off];
        }
    memcpy(grown, spare, count);
    for (int y = 0; y < height; y++)
        for (int other = y > reach ? y - reach : 0; other <= y + reach && other < height; other++) {
            const uint8_t *restrict from = spare + (int64_t)width * other;
            uint8_t *restrict to = grown + (int64_t)width * y;
            for (int x = 0; x < width; x++)
                to[x] |= from[x];
        }
    for (int64_t at = 0; at < count; at++)
        grown[at] ^= of;
}

FAST static void find_grays(const Pixels *pixels, int64_t count)
{
    const uint8_t *restrict seen = pixels->seen, *restrict rim = pixels->rim, *restrict core = pixels->core;
    const float *restrict wall = pixels->wall;
    int32_t *restrict bright = pixels->grays[0], *restrict usual = pixels->grays[1];
    for (int64_t at = 0; at < count; at++) {
        int is_free = !(rim[at] | core[at]);
        float gray = 0.114f * wall[3 * at] + 0.587f * wall[3 * at + 1] + 0.299f * wall[3 * at + 2];
        bright[at] = is_free * (PIXEL_OF_BGR(seen + 3 * at) >> (14 - GRAY_BITS));
        usual[at] = is_free * (int32_t)((1 << GRAY_BITS) * within(gray, MOST_GRAY) + 0.5f);
    }
}

/* Add a row of pixels to sums of each column, or subtract it if ``sign`` is -1: the weight of its colors in those of a
   thing, and the weighted colors. */
FAST static void add_colors(const Pixels *pixels, int64_t from, int width, int sign, Sums *restrict sums)
{
    for (int x = 0; x < width; x++) {
        const uint8_t *color = pixels->seen + 3 * (from + x);
        int weight = sign * (CORE_WEIGHT * pixels->core[from + x] + FRONT_WEIGHT * pixels->front[from + x]);
        sums[x] += (Sums){1, color[0], color[1], color[2]} * weight;
    }
}

FAST static void add_grays(const Pixels *pixels, int64_t from, int width, int sign, int32_t *restrict bright,
                           int32_t *restrict usual)
{
    for (int x = 0; x < width; x++) {
        bright[x] += sign * pixels->grays[0][from + x];
        usual[x] += sign * pixels->grays[1][from + x];
    }
}

static float product3(const float one[3], const float other[3])
{
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2];
}

/* The share of the thing in a color, which is share * thing + rest * wall. Least squares tell both factors, where rest is
   expected to be (1 - share) * shade. ``off``: how far the mixture is off, gray levels. */
static float mixture(const float color[3], const float thing[3], const float wall[3], float shade, float *off)
{
    const float trust = SHADE_LEVELS * SHADE_LEVELS, least = 3 * MIN_CONTRAST * MIN_CONTRAST;
    float thing_thing = product3(thing, thing) + trust * shade * shade;
    float thing_wall = product3(thing, wall) + trust * shade, wall_wall = product3(wall, wall) + trust;
    float thing_color = product3(thing, color) + trust * shade * shade;
    float wall_color = product3(wall, color) + trust * shade;
    /* With less contrast than the least, nothing is known. */
    float determinant = thing_thing * wall_wall - thing_wall * thing_wall + least * wall_wall;
    float share = within((thing_color * wall_wall - wall_color * thing_wall) / determinant, 1);
    float rest = (wall_color - share * thing_wall) / wall_wall;
    *off = SHADE_LEVELS * fabsf(rest - (1 - share) * shade);
    for (int channel = 0; channel < 3; channel++)
        *off = larger(*off, fabsf(color[channel] - share * thing[channel] - rest * wall[channel]));
    return share;
}

/* The share of a pixel at a rim. ``sums``: see add_colors, in its window. ``bright``, ``usual``: of the grays there. */
static float share_at(const Pixels *pixels, int64_t at, Sums sums, int32_t bright, int32_t usual)
{
    const float little = 1e-3f * (1 << GRAY_BITS) * (2 * SHADE_REACH + 1) * (2 * SHADE_REACH + 1);
    float color[3], thing[3], off, weight = larger((float)sums[0], 1);
    for (int channel = 0; channel < 3; channel++) {
        color[channel] = pixels->seen[3 * at + channel];
        thing[channel] = sums[1 + channel] / weight;
    }
    float share = mixture(color, thing, pixels->wall + 3 * at, (bright + little) / (usual + little), &off);
    int is_shadow = share < SHADOW_SHARE && off < SHADOW_LEVELS;
    return pixels->inner[at] && !is_shadow ? 1 : share;
}

/* ``sums``, ``grays``: room for one row, 0. */
static void find_shares(const Pixels *pixels, int width, int height, Sums *sums, int32_t *grays, float *share)
{
    int32_t *bright = grays, *usual = grays + width;
    for (int y = -THING_REACH; y <= THING_REACH; y++)
        add_colors(pixels, (int64_t)width * mirrored(y, height), width, 1, sums);
    for (int y = -SHADE_REACH; y <= SHADE_REACH; y++)
        add_grays(pixels, (int64_t)width * mirrored(y, height), width, 1, bright, usual);
    for (int y = 0; y < height; y++) {
        Sums wide = {0};
        int32_t of_bright = 0, of_usual = 0;
        for (int x = -THING_REACH; x <= THING_REACH; x++)
            wide += sums[mirrored(x, width)];
        for (int x = -SHADE_REACH; x <= SHADE_REACH; x++) {
            of_bright += bright[mirrored(x, width)];
            of_usual += usual[mirrored(x, width)];
        }
        for (int x = 0; x < width; x++) {
            int64_t at = (int64_t)width * y + x;
            share[at] = pixels->rim[at] ? share_at(pixels, at, wide, of_bright, of_usual) : pixels->core[at];
            int is_inner = x >= THING_REACH && x + THING_REACH + 1 < width;  /* there, nothing is mirrored */
            int next = x + THING_REACH + 1, last = x - THING_REACH;
            wide += sums[is_inner ? next : mirrored(next, width)] - sums[is_inner ? last : mirrored(last, width)];
            next = is_inner ? x + SHADE_REACH + 1 : mirrored(x + SHADE_REACH + 1, width);
            last = is_inner ? x - SHADE_REACH : mirrored(x - SHADE_REACH, width);
            of_bright += bright[next] - bright[last];
            of_usual += usual[next] - usual[last];
        }
        add_colors(pixels, (int64_t)width * mirrored(y + THING_REACH + 1, height), width, 1, sums);
        add_colors(pixels, (int64_t)width * mirrored(y - THING_REACH, height), width, -1, sums);
        add_grays(pixels, (int64_t)width * mirrored(y + SHADE_REACH + 1, height), width, 1, bright, usual);
        add_grays(pixels, (int64_t)width * mirrored(y - SHADE_REACH, height), width, -1, bright, usual);
    }
}

int unit5_find_rim(const uint8_t *seen, const float *wall, const uint8_t *front, int width, int height, float *share)
{
    int64_t count = (int64_t)width * height;
    uint8_t *masks = malloc(4 * count + 1);
    int32_t *grays = calloc(2 * count + 2 * width + 1, sizeof *grays);
    Sums *sums = calloc(width + 1, sizeof *sums);
    int is_enough = masks && grays && sums;
    if (is_enough && count > 0) {
        uint8_t *core = masks, *inner = masks + count, *rim = masks + 2 * count, *spare = masks + 3 * count;
        Pixels pixels = {seen, front, wall, core, inner, rim, {grays, grays + count}};
        grow(front, 1, CORE_REACH, width, height, spare, core);
        grow(front, 1, INNER_REACH, width, height, spare, inner);
        grow(front, 0, 1, width, height, spare, rim);
        for (int64_t at = 0; at < count; at++)
            rim[at] &= !core[at];
        find_grays(&pixels, count);
        find_shares(&pixels, width, height, sums, grays + 2 * count, share);
    }
    free(masks);
    free(grays);
    free(sums);
    return is_enough;
}
