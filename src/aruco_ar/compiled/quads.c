/* Finding quadrilaterals in an image: the outlines of what is darker than its surroundings, if they have four straight
   sides.

   A pixel is dark if it is darker than the mean of the window around it. The outlines of the dark parts are followed
   along the sides of pixels, always with dark on the right, so outlines of holes go around counterclockwise. Pixels
   that touch at a corner belong together. */
#include <stdlib.h>

#include "unit5.h"

#define DARKER 7         /* gray levels below the mean, at least */
#define ROWS_APART 4     /* an outline is looked for in each fourth row; one that is less high is too small */
#define MAX_ROUGH 1.6f   /* most steps of an outline, relative to those around its bounding box */
#define MAX_LONG 4       /* longest outline, relative to the longer side of the image */
#define MAX_OFF 0.05f    /* an outline is at most this far off its four sides, relative to their sum */
#define MIN_SIDE 0.05f   /* shortest side, relative to the sum of all */
#define SKIPPED 0.12f    /* share of a side that is left out at each end, since corners are rounded by blur */
#define MAX_MOVED 0.15f  /* a corner is moved at most this far by fitting lines, relative to the sum of all sides */

enum { LIGHT, DARK, PASSED };  /* PASSED: dark, and its left side belongs to an outline that was followed */

/* A point where an outline turns: the top left of the pixel that is there. */
typedef struct { int x, y; } Turn;
typedef struct { Turn *turns; int count; int64_t steps; int left, right, top, bottom; } Outline;

const int unit5_widest_window = 15;  /* the gray of all pixels in it, summed, is less than 2^16 */

/* Sum the columns of the window around a row, with ``reach`` more columns on both sides, as copies of the outer ones.
   ``sums``: those of the row before, and then of this one. */
static void sum_columns(const Image *image, int row, int reach, uint16_t *sums)
{
    int width = image->width, last = image->height - 1;
    uint16_t *inner = sums + reach;
#define ROW(number) (image->pixels + image->row * ((number) < 0 ? 0 : (number) > last ? last : (number)))
    if (row == 0) {
        memset(inner, 0, width * sizeof *inner);
        for (int other = -reach; other <= reach; other++) {
            const uint8_t *pixels = ROW(other);
            for (int x = 0; x < width; x++)
                inner[x] += pixels[x];
        }
    } else {
        const uint8_t *enters = ROW(row + reach), *leaves = ROW(row - reach - 1);
        for (int x = 0; x < width; x++)
            inner[x] += enters[x] - leaves[x];
    }
#undef ROW
    for (int x = 0; x < reach; x++) {
        sums[x] = inner[0];
        inner[width + x] = inner[width - 1];
    }
}

/* Write which pixels of a row are dark. ``sums``: those of the columns around it. ``fours``: room for width + window
   numbers. All sums are those of at most 15 x 15 pixels. Inlined for each window, all of this is vectors: that takes two
   thirds of the time of a running sum, in which each number waits for the one before. */
static inline __attribute__((always_inline)) void find_dark_row(const uint8_t *gray, int width, int window,
                                                                const uint16_t *sums, uint16_t *fours, uint8_t *row)
{
    for (int x = 0; x < width + window - 4; x++)
        fours[x] = sums[x] + sums[x + 1] + sums[x + 2] + sums[x + 3];
    const uint16_t area = window * window;
    for (int x = 0; x < width; x++) {
        uint16_t all = 0, least = (gray[x] + DARKER) * area;
        int at = 0;
        for (; at + 4 <= window; at += 4)
            all += fours[x + at];
        for (; at < window; at++)
            all += sums[x + at];
        row[x] = all >= least ? DARK : LIGHT;
    }
}

/* Write which pixels are dark; ``dark`` has a rim of one pixel, which is light before. ``window``: odd, from 3 to 15.
   ``sums``, ``fours``: room for width + window numbers each. */
static void find_dark(const Image *image, int window, uint8_t *dark, uint16_t *sums, uint16_t *fours)
{
    for (int y = 0; y < image->height; y++) {
        const uint8_t *gray = image->pixels + image->row * y;
        uint8_t *row = dark + (int64_t)(image->width + 2) * (y + 1) + 1;
        sum_columns(image, y, window / 2, sums);
        switch (window) {
#define CASE(known) case known: find_dark_row(gray, image->width, known, sums, fours, row); break
        CASE(3); CASE(5); CASE(7); CASE(9); CASE(11); CASE(13); CASE(15);
#undef CASE
        }
    }
}

/* Follow an outline from the left side of a pixel, upward. ``room``: for turns; more are not kept. */
static void follow(uint8_t *dark, int width, int x, int y, int room, Outline *outline)
{
    const int64_t row = width + 2;
    /* Of each direction, up, right, down and left: one step, and the pixels ahead on the left and on the right. They
       are relative to the pixel at the bottom right of where the outline is. */
    const int64_t steps[4] = {-row, 1, row, -1};
    const int64_t lefts[4] = {-row - 1, -row, 0, -1}, rights[4] = {-row, 0, -1, -row - 1};
    static const int across[4] = {0, 1, 0, -1}, down[4] = {-1, 0, 1, 0};
    uint8_t *start = dark + row * (y + 2) + x + 1, *at = start;  /* the pixel is above and to the right */
    int direction = 0, count = 0, left = x, right = x, top = y, bottom = y;
    int64_t all = 0;
    y++;
    do {
        int run = 0;
        int next;
        do {
            if (direction == 0)
                at[-row] = PASSED;
            at += steps[direction];
            run++;
            next = at[lefts[direction]] ? 3 : at[rights[direction]] ? 0 : 1;
        } while (next == 0 && at != start);
        all += run;
        x += run * across[direction];
        y += run * down[direction];
        left = x < left ? x : left, right = x > right ? x : right;
        top = y < top ? y : top, bottom = y > bottom ? y : bottom;
        if (count < room && (next || at == start))
            outline->turns[count] = (Turn){x, y};
        count += next != 0 || at == start;
        direction = (direction + next) & 3;
    } while (at != start || direction != 0);
    outline->count = count, outline->steps = all;
    outline->left = left, outline->right = right, outline->top = top, outline->bottom = bottom;
}

/* The turn that is farthest from the line through two others, of those from one to the other; with ``far``: how far. */
static int farthest(const Outline *outline, int from, int to, float *far)
{
    const Turn *turns = outline->turns;
    Turn start = turns[from], end = turns[to];
    int64_t along_x = end.x - start.x, along_y = end.y - start.y, most = -1;
    int best = from;
    for (int index = from; index != to; index = index + 1 < outline->count ? index + 1 : 0) {
        int64_t off = along_x * (turns[index].y - start.y) - along_y * (turns[index].x - start.x);
        off = off < 0 ? -off : off;
        if (off > most)
            most = off, best = index;
    }
    *far = most / sqrtf((float)(along_x * along_x + along_y * along_y));
    return best;
}

static int farthest_from(const Outline *outline, Turn from)
{
    int64_t most = -1;
    int best = 0;
    for (int index = 0; index < outline->count; index++) {
        int64_t across = outline->turns[index].x - from.x, down = outline->turns[index].y - from.y;
        int64_t square = across * across + down * down;
        if (square > most)
            most = square, best = index;
    }
    return best;
}

static Point point_of(Turn turn) { return (Point){turn.x - 0.5f, turn.y - 0.5f}; }

/* Find the turns that are the four corners, in the order of the outline, as Douglas and Peucker do: the turn farthest
   from a side becomes a corner. ``around``: the sum of the sides. Returns 0 if not exactly four are needed. */
static int find_corners(const Outline *outline, int corners[4], float *around)
{
    float off[4];
    int next[4];
    corners[0] = farthest_from(outline, outline->turns[0]);
    corners[1] = farthest_from(outline, outline->turns[corners[0]]);
    for (int count = 2; count <= 4; count++) {
        int split = 0;
        *around = 0;
        for (int side = 0; side < count; side++) {
            int end = corners[(side + 1) % count];
            if (count == 2 || next[side] < 0)
                next[side] = farthest(outline, corners[side], end, off + side);
            split = off[side] > off[split] ? side : split;
            *around += length(minus(point_of(outline->turns[end]), point_of(outline->turns[corners[side]])));
        }
        if (count == 4)
            return off[split] <= MAX_OFF * *around;
        if (!(off[split] > MAX_OFF * *around))
            return 0;
        for (int side = count; side > split + 1; side--)
            corners[side] = corners[side - 1], next[side] = next[side - 1], off[side] = off[side - 1];
        corners[split + 1] = next[split];
        next[split] = next[split + 1] = -1;
    }
    return 0;
}

/* The line that fits the middles of the steps of a side best: a point on it, and its direction. */
static void fit_line(const Outline *outline, int from, int to, Point *on, Point *along)
{
    int64_t steps = 0, number = 0, counted = 0;
    double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    const Turn *turns = outline->turns, first = turns[from];
    for (int pass = 0; pass < 2; pass++) {
        int64_t skipped = pass ? (int64_t)(SKIPPED * steps) : 0;
        for (int index = from; index != to;) {
            int next = index + 1 < outline->count ? index + 1 : 0;
            Turn a = turns[index], b = turns[next];
            int across = (b.x > a.x) - (b.x < a.x), down = (b.y > a.y) - (b.y < a.y);
            int run = abs(b.x - a.x) + abs(b.y - a.y);
            if (!pass)
                steps += run;
            for (int step = 0; pass && step < run; step++, number++) {
                if (number < skipped || number >= steps - skipped)
                    continue;
                double u = a.x - first.x + (step + 0.5) * across, v = a.y - first.y + (step + 0.5) * down;
                x += u, y += v, xx += u * u, xy += u * v, yy += v * v;
                counted++;
            }
            index = next;
        }
    }
    x /= counted, y /= counted;
    double angle = atan2(2 * (xy / counted - x * y), (xx - yy) / counted - x * x + y * y) / 2;
    *on = plus(point_of(first), 1, (Point){x, y});
    *along = (Point){cos(angle), sin(angle)};
}

/* The quadrilateral that an outline is, clockwise, its corners where the lines along its sides cross. Returns 0 if it
   is none, or if its sides are shorter, in all, than ``shortest``. */
static int find_quad(const Outline *outline, float shortest, Point quad[4])
{
    int corners[4];
    float around;
    if (outline->count < 4 || !find_corners(outline, corners, &around) || around < shortest)
        return 0;
    Point on[4], along[4], fitted[4];
    for (int side = 0; side < 4; side++) {
        Turn from = outline->turns[corners[side]], to = outline->turns[corners[(side + 1) & 3]];
        if (length(minus(point_of(to), point_of(from))) < MIN_SIDE * around)
            return 0;
        fit_line(outline, corners[side], corners[(side + 1) & 3], on + side, along + side);
    }
    int turned = 0;
    for (int corner = 0; corner < 4; corner++) {
        int before = (corner + 3) & 3;
        Point seen = point_of(outline->turns[corners[corner]]);
        float angle = cross(along[before], along[corner]);
        fitted[corner] = plus(on[before], cross(minus(on[corner], on[before]), along[corner]) / angle, along[before]);
        if (!(length(minus(fitted[corner], seen)) <= MAX_MOVED * around))  /* also true for NaN */
            fitted[corner] = seen;
    }
    for (int corner = 0; corner < 4; corner++) {
        Point side = minus(fitted[(corner + 1) & 3], fitted[corner]);
        float turn = cross(side, minus(fitted[(corner + 2) & 3], fitted[(corner + 1) & 3]));
        turned += turn > 0 ? 1 : turn < 0 ? -1 : 0;
    }
    int first = 0;  /* at the top left, so that a tag that looks the same when it is turned is upright */
    for (int corner = 1; corner < 4; corner++)
        first = fitted[corner].x + fitted[corner].y < fitted[first].x + fitted[first].y ? corner : first;
    for (int corner = 0; corner < 4; corner++)
        quad[corner] = fitted[turned > 0 ? (first + corner) & 3 : (first - corner) & 3];
    return turned == 4 || turned == -4;
}

int64_t unit5_find_quads(const Image *image, int window, float shortest, int64_t room, Point *quads)
{
    int width = image->width, height = image->height;
    int64_t row = width + 2, found = 0;
    int longer = width > height ? width : height;
    int turns = 2 * MAX_LONG * longer;
    uint8_t *dark = calloc(row * (height + 2) + sizeof(uint64_t), 1);
    uint16_t *sums = malloc(2 * (width + window) * sizeof *sums);
    Outline outline = {.turns = malloc(turns * sizeof(Turn))};
    if (dark && sums && outline.turns) {
        find_dark(image, window, dark, sums, sums + width + window);
        const uint64_t ones = 0x0101010101010101;
        for (int y = ROWS_APART / 2; y < height; y += ROWS_APART)
            for (int x = 0; x < width; x += 8) {
                uint64_t here, before;
                const uint8_t *at = dark + row * (y + 1) + 1 + x;
                memcpy(&here, at, 8);
                memcpy(&before, at - 1, 8);
                uint64_t starts = here & ~(before | before >> 1) & ones;  /* the byte of PASSED is 2 */
                if (!starts)
                    continue;
                for (int at_x = x; at_x < x + 8 && at_x < width; at_x++, at++) {
                    if (at[0] != DARK || at[-1] != LIGHT)
                        continue;
                    follow(dark, width, at_x, y, turns, &outline);
                    int around = 2 * (outline.right - outline.left + outline.bottom - outline.top);
                    Point quad[4];
                    if (outline.count > turns || around < shortest || around > MAX_LONG * longer
                            || outline.steps > MAX_ROUGH * around || !find_quad(&outline, shortest, quad))
                        continue;
                    if (found++ < room)
                        memcpy(quads + 4 * (found - 1), quad, sizeof quad);
                }
            }
    } else {
        found = -1;
    }
    free(outline.turns);
    free(sums);
    free(dark);
    return found;
}
