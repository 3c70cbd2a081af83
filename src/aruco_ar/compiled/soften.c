/* A picture that is as soft as the camera's image: blurred together with its mask, so that black beyond the rim does
   not get into its colors.

   Both are multiplied by the mask, blurred across, row by row, and then down, from the last few of these rows. The
   blurred colors are divided by the blurred mask. Numbers have ONE as the unit: sums of two still have 16 bits. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "shares.h"
#include "unit5.h"
#include "vectors.h"

#define ONE 128
#define RUN 192  /* so many numbers are computed at once */

/* Weights of a normal distribution, times 2^16: of the middle, and of the places up to ``reach`` from it. */
typedef struct { int reach; uint16_t *weights; } Kernel;

static int reach_of(double deviation) { return (int)(3 * deviation + 0.5); }

static void find_kernel(Kernel *kernel, double deviation)
{
    double sum = 1;
    for (int at = 1; at <= kernel->reach; at++)
        sum += 2 * exp(-at * at / (2 * deviation * deviation));
    for (int at = 0; at <= kernel->reach; at++) {
        double weight = 65536 / sum * (at ? exp(-at * at / (2 * deviation * deviation)) : 1);
        kernel->weights[at] = weight < 65535 ? weight + 0.5 : 65535;
    }
}

/* The place within 0 to count - 1 that a place beyond is mirrored to. */
static int mirrored(int at, int count)
{
    while (count > 1 && (at < 0 || at >= count))
        at = at < 0 ? -at : 2 * (count - 1) - at;
    return count > 1 ? at : 0;
}

/* Add RUN numbers, and those on the other side, to a sum. In the loop that calls it, GCC would not vectorize this. */
FAST static void add_run(const uint16_t *restrict one, const uint16_t *restrict other, uint16_t weight,
                         uint16_t *restrict sum)
{
    for (int n = 0; n < RUN; n++)
        sum[n] += (uint32_t)(uint16_t)(one[n] + other[n]) * weight >> 16;
}

/* Blur the numbers from ``begin`` to before ``end``, which are multiples of RUN. ``before`` and ``after``: for each place
   up to the kernel's reach, the numbers so far away. */
FAST static void blur(const Kernel *kernel, const uint16_t *const *before, const uint16_t *const *after,
                      int64_t begin, int64_t end, uint16_t *restrict blurred)
{
    for (int64_t from = begin; from < end; from += RUN) {
        const uint16_t *middle = before[0] + from;
        uint16_t sum[RUN];
        for (int n = 0; n < RUN; n++)  /* each product is half a unit too small, in the mean */
            sum[n] = (kernel->reach + 1) / 2 + ((uint32_t)middle[n] * kernel->weights[0] >> 16);
        for (int at = 1; at <= kernel->reach; at++)
            add_run(before[at] + from, after[at] + from, kernel->weights[at], sum);
        memcpy(blurred + from, sum, sizeof sum);
    }
}

/* Some rows that were blurred across. ``numbers``: of each, the colors, and then the mask. ``size``: how many numbers
   either has, a multiple of RUN. ``begin``, ``end``: which of them are not 0, multiples of RUN. */
typedef struct { int64_t size; int *begin, *end; uint16_t *numbers; } Rows;

/* ``padded``: a row with ``3 * reach`` numbers more on each side. Mirrors the row into them, and blurs it. */
static void blur_across(uint16_t *padded, int width, const Kernel *kernel, const uint16_t **before,
                        const uint16_t **after, int64_t begin, int64_t end, uint16_t *blurred)
{
    uint16_t *row = padded + 3 * kernel->reach;
    for (int at = 1; at <= kernel->reach; at++)
        for (int channel = 0; channel < 3; channel++) {
            row[-3 * at + channel] = row[3 * mirrored(-at, width) + channel];
            row[3 * (width - 1 + at) + channel] = row[3 * mirrored(width - 1 + at, width) + channel];
        }
    for (int at = 0; at <= kernel->reach; at++) {
        before[at] = row - 3 * at;
        after[at] = row + 3 * at;
    }
    blur(kernel, before, after, begin, end, blurred);
}

/* Multiply a row of colors by its mask, and change both to the unit. */
FAST static void multiply(const uint8_t *restrict colors, const uint8_t *restrict mask, int64_t count,
                          uint16_t *restrict color, uint16_t *restrict cover)
{
    for (int64_t n = 0; n < count; n++) {
        color[n] = product(colors[n], mask[n]) * ONE;
        cover[n] = mask[n] * ONE;
    }
}

/* Divide the numbers from ``begin`` to before ``end`` by the mask, where there is any of it; both are rounded first.
   ``count``: numbers of a row of the result. */
FAST static void divide(const uint16_t *restrict colors, const uint16_t *restrict mask, int64_t begin, int64_t end,
                        int64_t count, uint8_t *restrict divided, uint8_t *restrict share)
{
    for (int64_t from = begin; from < end; from += RUN) {
        uint8_t color[RUN], cover[RUN], least = 255;
        for (int n = 0; n < RUN; n++) {
            cover[n] = (uint16_t)(mask[from + n] + ONE / 2) / ONE;
            color[n] = (uint16_t)(colors[from + n] + ONE / 2) / ONE;
            least = cover[n] < least ? cover[n] : least;
        }
        if (least < 255)
            for (int n = 0; n < RUN; n++)
                color[n] = smaller(255, 255.0f * color[n] / larger(cover[n], 1) + 0.5f);
        int64_t length = count - from < RUN ? count - from : RUN;
        memcpy(divided + from, color, length);
        memcpy(share + from, cover, length);
    }
}

/* ``padded``: two rows, see blur_across. ``blurred``: room for the colors and the mask of a row. ``before``, ``after``:
   room for the places of the longer kernel. */
static void soften(const Image *picture, const Image *mask, const Kernel *across, const Kernel *down,
                   const Rows *rows, uint16_t *padded[2], uint16_t *blurred, const uint16_t **before,
                   const uint16_t **after, uint8_t *softened, uint8_t *share)
{
    int height = mask->height, count = 2 * down->reach + 1, known = 0;
    int64_t numbers = 3 * (int64_t)mask->width;
    for (int y = 0; y < height; y++) {
        for (; known < height && known <= y + down->reach; known++) {
            int slot = known % count;
            const uint8_t *shown = mask->pixels + mask->row * known, *colors = picture->pixels + picture->row * known;
            uint16_t *color = padded[0] + 3 * across->reach, *cover = padded[1] + 3 * across->reach;
            multiply(colors, shown, numbers, color, cover);
            int64_t begin = 0, end = numbers;
            while (begin < end && !shown[begin])
                begin++;
            while (begin < end && !shown[end - 1])
                end--;
            int is_empty = begin == end;
            begin = is_empty || begin < 3 * across->reach ? 0 : (begin - 3 * across->reach) / RUN * RUN;
            end = is_empty ? 0 : (end + 3 * across->reach + RUN - 1) / RUN * RUN;
            rows->begin[slot] = begin;
            rows->end[slot] = end = end < rows->size ? end : rows->size;
            for (int part = 0; part < 2; part++) {
                uint16_t *row = rows->numbers + rows->size * (2 * slot + part);
                memset(row, 0, begin * sizeof *row);
                memset(row + end, 0, (rows->size - end) * sizeof *row);
                blur_across(padded[part], mask->width, across, before, after, begin, end, row);
            }
        }
        int64_t begin = rows->size, end = 0;
        for (int at = -down->reach; at <= down->reach; at++) {
            int slot = mirrored(y + at, height) % count;
            if (rows->end[slot]) {
                begin = rows->begin[slot] < begin ? rows->begin[slot] : begin;
                end = rows->end[slot] > end ? rows->end[slot] : end;
            }
            *(at <= 0 ? before - at : after + at) = rows->numbers + 2 * rows->size * slot;
        }
        blur(down, before, after, begin, end, blurred);
        blur(down, before, after, rows->size + begin, rows->size + end, blurred);
        divide(blurred, blurred + rows->size, begin, end, numbers, softened + numbers * y, share + numbers * y);
    }
}

int unit5_soften_picture(const Image *picture, const Image *mask, double across, double down, uint8_t *softened,
                         uint8_t *share)
{
    Kernel kernels[2] = {{.reach = reach_of(across)}, {.reach = reach_of(down)}};
    int count = 2 * kernels[1].reach + 1, places = kernels[0].reach + kernels[1].reach + 2;
    Rows rows = {.size = (3 * (int64_t)mask->width + RUN - 1) / RUN * RUN};
    int64_t wide = rows.size + 6 * kernels[0].reach, room = 2 * wide + 2 * rows.size * (count + 1) + places;
    uint16_t *numbers = calloc(room, sizeof *numbers);
    const uint16_t **pointers = malloc(2 * places * sizeof *pointers);
    int *ends = malloc(2 * count * sizeof *ends), is_enough = numbers && pointers && ends;
    if (is_enough) {
        uint16_t *padded[2] = {numbers, numbers + wide};
        rows.numbers = numbers + 2 * wide;
        rows.begin = ends;
        rows.end = ends + count;
        uint16_t *blurred = rows.numbers + 2 * rows.size * count;
        kernels[0].weights = blurred + 2 * rows.size;
        kernels[1].weights = kernels[0].weights + kernels[0].reach + 1;
        find_kernel(&kernels[0], across);
        find_kernel(&kernels[1], down);
        soften(picture, mask, &kernels[0], &kernels[1], &rows, padded, blurred, pointers, pointers + places, softened,
               share);
    }
    free(numbers);
    free(pointers);
    free(ends);
    return is_enough;
}
