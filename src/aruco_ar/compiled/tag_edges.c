/* Fitting tags to their edges in the frame, and comparing what is seen with their cells.

   A tag's edge is black inside and white outside, or the other way round. It is sampled along short
   lines across it, its profiles. The share of light samples tells where the
   edge crosses a profile, to some hundredths of a pixel, even if it is blurred.

   This is in C because it would need hundreds of calls of NumPy for each frame. */
#include "tag_cells.h"
#include "unit5.h"
#include "vectors.h"

#define PROFILES 12       /* profiles along each edge */
#define FIRST 0.08f       /* the positions of the first and the last profile along the edge, 0 to 1: a rounded */
#define LAST 0.92f        /* corner is left out */
#define SAMPLES 15        /* samples of each profile */
#define ENDS (SAMPLES / 5) /* samples at each end of a profile, which tell how dark and how light it is */
/* How far a profile reaches to both sides of an edge, in cells: COARSE to find an edge,
   FINE to measure it. With a longer reach, shading would bend a straight edge. If an
   edge is off by more than NEAR of the fine reach, it is searched with the coarse one. */
#define COARSE 0.95f
#define FINE 0.6f
#define NEAR 0.4f
#define MIN_COARSE_PX 1.8f
#define MIN_FINE_PX 1.2f
#define MAX_FINE_PX 5.0f
#define SETTLED_PX 0.5f   /* if a corner was off by more, the quadrilateral is fitted once more */
#define MAX_BENT 0.35f    /* half of an edge's profiles must be off its line by less than this share of the reach */
#define LEAST_SEEN 3      /* so many edges of a tag must be seen if something covers the others */
#define LEAST_CELL_PX 3.0f  /* with smaller cells, blur mixes what covers an edge into those beside it */
#define MIN_WITHIN_PX 1   /* nearer to the frame's rim, an edge is not measured by profiles across it */
#define MARGIN_LIGHT 0.9f /* samples at least this light, as a share of the contrast, are the margin */
#define STEADY 0.5f       /* with a narrow margin, most profiles must have this share of the contrast */
/* There is a shadow on a part of a tag if what is around it is lighter by this factor on one side than on another. */
#define UNEVEN 2.0f
#define ACROSS 0.25f      /* a quadrilateral is looked at across its sides here, in the middle, and at 1 - this */

#define POSITION(profile) (FIRST + (LAST - FIRST) * (profile) / (PROFILES - 1))
const int unit5_profile_count = PROFILES;
const float unit5_profile_positions[PROFILES] = {
    POSITION(0), POSITION(1), POSITION(2), POSITION(3), POSITION(4), POSITION(5),
    POSITION(6), POSITION(7), POSITION(8), POSITION(9), POSITION(10), POSITION(11)};

/* Profiles are computed by fours. */
typedef int FourInts __attribute__((vector_size(16)));
#define FOURS (PROFILES / 4)
_Static_assert(PROFILES % 4 == 0, "profiles are computed by fours");
/* The first sample of all profiles, the second one of all, and so on. */
typedef Four Gray[SAMPLES][FOURS];
typedef struct { float middle, slope; Four off[FOURS]; } Line;

static Four numbers_of(int four) { return (Four){4 * four, 4 * four + 1, 4 * four + 2, 4 * four + 3}; }
static Four larger_of(Four a, Four b)
{
    FourInts first = a > b;
    return (Four)((first & (FourInts)a) | (~first & (FourInts)b));
}

/* The value of the profiles with that rank, from 0, when they are sorted. */
static float ranked(const Four values[FOURS], int rank)
{
    for (int i = 0; i < PROFILES; i++) {
        Four value = values[i / 4][i % 4] - (Four){0};
        FourInts less = {0}, others = {0};  /* a comparison that is true is -1 */
        for (int four = 0; four < FOURS; four++) {
            less -= values[four] < value;
            others -= values[four] <= value;
        }
        if (less[0] + less[1] + less[2] + less[3] <= rank && rank < others[0] + others[1] + others[2] + others[3])
            return value[0];
    }
    return values[0][0];  /* some are not numbers */
}

static float median(const Four values[FOURS]) { return ranked(values, PROFILES / 2); }

/* The mean of each profile's samples from the first one to the one before the last. */
static void means(Gray gray, int first, int last, Four mean[FOURS])
{
    float share = 1.0f / (last - first);
    memset(mean, 0, FOURS * sizeof *mean);
    for (int sample = first; sample < last; sample++)
        for (int four = 0; four < FOURS; four++)
            mean[four] += gray[sample][four] * share;
}

/* The line middle + slope * arm through the offsets of profiles, where arm is a profile's distance from the middle
   of the edge. Also the distances of the offsets from this line. */
static Line line_through(const Four offset[FOURS], const Four weight[FOURS])
{
    Four count = {0}, first = {0}, second = {0}, sum = {0}, leaning = {0}, arm[FOURS];
    for (int four = 0; four < FOURS; four++) {
        arm[four] = (LAST - FIRST) / (PROFILES - 1) * numbers_of(four) - (LAST - FIRST) / 2;
        count += weight[four];
        first += weight[four] * arm[four];
        second += weight[four] * arm[four] * arm[four];
        sum += weight[four] * offset[four];
        leaning += weight[four] * offset[four] * arm[four];
    }
    float all = sum_of(count), mean = sum_of(first) / all, total = sum_of(sum);
    Line line;
    line.slope = (sum_of(leaning) - mean * total) / (sum_of(second) - mean * mean * all + 1e-9f);
    line.middle = total / all - line.slope * mean;
    for (int four = 0; four < FOURS; four++) {
        Four off = offset[four] - line.middle - line.slope * arm[four];
        line.off[four] = larger_of(off, -off);
    }
    return line;
}

/* Whether the white margin ends within an edge's profiles, since the paper is cut close to the tag. Then also the
   first sample on the margin, and the first one beyond it, which may be of any shade. */
static int narrow_margin(Gray gray, float dark, int *begins, int *ended)
{
    float typical[SAMPLES], lightest = 0;
    for (int sample = 0; sample < SAMPLES; sample++) {
        Four sum = {0};
        for (int four = 0; four < FOURS; four++)
            sum += gray[sample][four];
        typical[sample] = sum_of(sum) / PROFILES;
        lightest = larger(lightest, typical[sample]);
    }
    float light = dark + MARGIN_LIGHT * (lightest - dark);
    if (lightest <= dark || typical[SAMPLES - 1] >= light)
        return 0;
    for (*begins = 0; typical[*begins] < light; ++*begins) {}
    for (*ended = *begins; typical[*ended] >= light; ++*ended) {}
    return 1;
}

/* Where an edge crosses its profiles, in pixels outward. Returns 0 if no edge is seen. */
static int offsets(Gray gray, float reach, Four offset[FOURS], int *narrow_margins)
{
    Four ends[FOURS], contrast[FOURS], zero = {0};
    means(gray, 0, ENDS, ends);
    float dark = median(ends);  /* one black for all profiles, but white may be shaded along an edge */
    int begins = SAMPLES - ENDS, ended = SAMPLES, narrow = narrow_margin(gray, dark, &begins, &ended);
    *narrow_margins |= narrow;
    means(gray, begins, ended, contrast);
    for (int four = 0; four < FOURS; four++) {
        contrast[four] -= dark;
        Four light = zero + (float)(SAMPLES - ended), scale = 1 / larger_of(contrast[four], zero + 1);
        for (int sample = 0; sample < ended; sample++) {
            /* Clipped: a sample far lighter or darker than both ends belongs to something else. */
            Four share = (gray[sample][four] - dark) * scale;
            light += larger_of(zero - MAX_BEYOND, -larger_of(-share, zero - (1 + MAX_BEYOND)));
        }
        offset[four] = (SAMPLES / 2.0f - light) * (reach * 2 / (SAMPLES - 1));
    }
    float typical = median(contrast);
    /* Noise may look like a narrow margin, too, but it has no contrast in most of an edge's profiles. */
    return typical > MIN_CONTRAST && (!narrow || ranked(contrast, PROFILES / 4) > STEADY * typical);
}

/* How many pixels the frame goes on from a point in a direction, a unit vector; negative outside of the frame. */
static float room(const Image *frame, Point at, Point direction)
{
    float across = direction.x > 0 ? frame->width - 1 - at.x : at.x, size = fabsf(direction.x);
    float down = direction.y > 0 ? frame->height - 1 - at.y : at.y, other = fabsf(direction.y);
    return smaller(across / larger(size, 1e-6f), down / larger(other, 1e-6f));
}

/* Whether there are pixels on all sides of a point. */
static int is_inside(const Image *frame, Point at)
{
    return at.x >= 0 && at.y >= 0 && at.x < frame->width - 1 && at.y < frame->height - 1;
}

/* The gray at points on a line within a frame. ``row``: the bytes from one row of pixels to the next. */
static void gray_within(const Image *frame, int row, Point from, Point step, Four gray[FOURS])
{
    const int right = frame->channels;
    for (int four = 0; four < FOURS; four++) {
        Four x = from.x + step.x * numbers_of(four), y = from.y + step.y * numbers_of(four);
        FourInts left = __builtin_convertvector(x, FourInts), top = __builtin_convertvector(y, FourInts);
        FourInts offsets = top * row + left * right, pixels[4];
        const uint8_t *start = frame->pixels;
#define FOUR(gray, more) (FourInts){gray(start + offsets[0] + (more)), gray(start + offsets[1] + (more)), \
                                    gray(start + offsets[2] + (more)), gray(start + offsets[3] + (more))}
        for (int corner = 0; corner < 4; corner++) {
            int more = (corner & 1) * right + (corner >> 1) * row;
            pixels[corner] = right == 1 ? FOUR(PIXEL_OF_GRAY, more) : FOUR(PIXEL_OF_BGR, more);
        }
#undef FOUR
        Four across = x - __builtin_convertvector(left, Four), down = y - __builtin_convertvector(top, Four);
        Four above = __builtin_convertvector(pixels[0], Four)
            + across * __builtin_convertvector(pixels[1] - pixels[0], Four);
        Four below = __builtin_convertvector(pixels[2], Four)
            + across * __builtin_convertvector(pixels[3] - pixels[2], Four);
        gray[four] = (above + down * (below - above)) * (right == 1 ? 1 : 1.0f / WHOLE_OF_BGR);
    }
}

/* The gray at points on a line from one point to another, both included. */
static void gray_along(const Image *frame, Point from, Point to, Four gray[FOURS])
{
    Point step = minus(to, from);
    step = (Point){step.x / (PROFILES - 1), step.y / (PROFILES - 1)};
    int is_small = frame->height * (frame->row < 0 ? -frame->row : frame->row) <= INT32_MAX;
    if (is_small && is_inside(frame, from) && is_inside(frame, plus(from, PROFILES - 1, step)))
        gray_within(frame, frame->row, from, step, gray);  /* usually, and faster */
    else
        for (int i = 0; i < PROFILES; i++)
            gray[i / 4][i % 4] = gray_at(frame, plus(from, i, step));
}

/* Fit a quadrilateral by profiles that reach that many pixels to both sides of each edge. Returns 0 if one of the
   edges is not found. ``inverted``: it is white inside. An edge with a reach of 0 stays as it is. Also whether a
   margin ends within that reach. */
static int fit_edges(const Image *frame, const Point quad[4], int inverted, const float reach[4], Point fitted[4],
                     int *narrow)
{
    Point first[4], along[4];
    *narrow = 0;
    for (int edge = 0; edge < 4; edge++) {
        along[edge] = minus(quad[(edge + 1) % 4], quad[edge]);
        float size = larger(length(along[edge]), 1e-6f);
        Point outward = {along[edge].y / size, -along[edge].x / size};
        first[edge] = quad[edge];
        if (!reach[edge])
            continue;
        Gray gray;
        Four offset[FOURS], weight[FOURS];
        Point start = plus(quad[edge], FIRST, along[edge]), end = plus(quad[edge], LAST, along[edge]);
        for (int sample = 0; sample < SAMPLES; sample++) {
            float out = reach[edge] * (2.0f * sample / (SAMPLES - 1) - 1);
            gray_along(frame, plus(start, out, outward), plus(end, out, outward), gray[sample]);
        }
        for (int sample = 0; inverted && sample < SAMPLES; sample++)
            for (int four = 0; four < FOURS; four++)
                gray[sample][four] = 255 - gray[sample][four];
        for (int four = 0; four < FOURS; four++)
            weight[four] = (Four){1, 1, 1, 1};
        if (!offsets(gray, reach[edge], offset, narrow))
            return 0;
        /* Fit a straight line through the offsets, then once more without outliers. */
        Line line = line_through(offset, weight);
        float most = 3 * median(line.off) + 0.01f * reach[edge];
        for (int four = 0; four < FOURS; four++)
            weight[four] = -__builtin_convertvector(line.off[four] <= most, Four);
        line = line_through(offset, weight);
        if (median(line.off) >= MAX_BENT * reach[edge])
            return 0;
        first[edge] = plus(quad[edge], line.middle - line.slope * (FIRST + LAST) / 2, outward);
        along[edge] = plus(along[edge], line.slope, outward);
    }
    for (int edge = 0; edge < 4; edge++) {  /* a corner is the crossing of two edges, as in lines.py */
        int before = (edge + 3) % 4;
        float crossed = cross(along[before], along[edge]);
        crossed = fabsf(crossed) < 1e-6f ? 1e-6f : crossed;
        float far = cross(minus(first[edge], first[before]), along[edge]) / crossed;
        fitted[edge] = plus(first[before], far, along[before]);
        if (!(length(minus(fitted[edge], quad[edge])) <= 3 * larger(reach[edge], reach[before])))
            return 0;
    }
    return 1;
}

/* How far profiles reach from each edge of a quadrilateral that is ``cells`` cells wide: as far as the frame goes
   on, but at least the least that shows an edge. Returns how many pixels the frame goes on beyond the edges. */
static float reaches(const Image *frame, const Point quad[4], int cells, float coarse[4], float fine[4],
                     float beyond[4])
{
    /* In a slanted view, cells are much narrower in one direction than in the other. */
    float area = fabsf(cross(minus(quad[2], quad[0]), minus(quad[3], quad[1]))) / 2, least = MAX_FINE_PX;
    for (int edge = 0; edge < 4; edge++) {
        Point from = quad[edge], to = quad[(edge + 1) % 4], along = minus(to, from);
        float size = larger(length(along), 1e-6f), cell = area / size / cells;
        Point outward = {along.y / size, -along.x / size};
        beyond[edge] = smaller(room(frame, from, outward), room(frame, to, outward));
        coarse[edge] = larger(COARSE * cell, MIN_COARSE_PX);
        fine[edge] = larger(smaller(smaller(FINE * cell, MAX_FINE_PX), beyond[edge]), MIN_FINE_PX);
        least = smaller(least, beyond[edge]);
    }
    return least;
}

/* Move a quadrilateral onto the edges of a tag that is ``cells`` cells wide. Returns 0 if an edge is not found. */
static int fit_tag(const Image *frame, const Point quad[4], int inverted, int cells, Point fitted[4], int *narrow)
{
    float coarse[4], fine[4], beyond[4];
    reaches(frame, quad, cells, coarse, fine, beyond);
    int near = fit_edges(frame, quad, inverted, fine, fitted, narrow), settled = 1;
    for (int corner = 0; near && corner < 4; corner++) {
        float moved = length(minus(fitted[corner], quad[corner]));
        near = moved < NEAR * fine[corner];
        settled &= moved < SETTLED_PX;
    }
    if (near && settled)
        return 1;
    Point found[4], measured[4];
    if (near) {
        memcpy(found, fitted, sizeof found);
        return fit_edges(frame, found, inverted, fine, fitted, narrow);
    }
    return fit_edges(frame, quad, inverted, coarse, found, narrow)
        && fit_edges(frame, found, inverted, fine, measured, narrow)
        && fit_edges(frame, measured, inverted, fine, fitted, narrow);
}

/* The correlation of what is seen in a quadrilateral with a tag's cells, (cells, cells), without a margin of that
   many cells. ``samples``: of each cell, in both directions. */
static float correlation(const Image *frame, const Point quad[4], int cells, const uint8_t *wanted, int margin,
                         int samples)
{
    double sum = 0, squares = 0, wanted_sum = 0, wanted_squares = 0, products = 0;
    Homography to = homography_to(quad);
    float step = 1.0f / (cells * samples);
    for (int row = margin; row < cells - margin; row++)
        for (int column = margin; column < cells - margin; column++) {
            double cell = wanted[row * cells + column], seen = 0;
            for (int sample = 0; sample < samples * samples; sample++) {
                int down = sample / samples, right = sample - down * samples;
                double gray = gray_at(frame, mapped(&to, (column * samples + right + 0.5f) * step,
                                                    (row * samples + down + 0.5f) * step));
                seen += gray;
                squares += gray * gray;
            }
            sum += seen;
            products += seen * cell;
            wanted_sum += cell * samples * samples;
            wanted_squares += cell * cell * samples * samples;
        }
    int64_t count = (int64_t)(cells - 2 * margin) * (cells - 2 * margin) * samples * samples;
    double spread = (squares - sum * sum / count) * (wanted_squares - wanted_sum * wanted_sum / count);
    return (products - sum * wanted_sum / count) / sqrt(fmax(spread, 1e-6));
}

void unit5_compare_tags(const Image *frame, int count, const Point *quads, int cells, const uint8_t *wanted,
                        int samples, float *likeness)
{
    for (int tag = 0; tag < count; tag++)
        likeness[tag] = correlation(frame, quads + 4 * tag, cells, wanted + tag * cells * cells, 0, samples);
}

/* Fit a quadrilateral to the edges between a tag's cells, and, ``at_rim``, where the tag is at the frame's rim,
   to those of its edges that are well within the frame. Returns 0 if too few of them are found. */
static int fit_inner(const Image *frame, const Point quad[4], int inverted, int cells, const uint8_t *wanted,
                     int at_rim, Point fitted[4])
{
    Point inner[4];
    float coarse[4], fine[4], beyond[4];
    int narrow;
    if (!fit_cells(frame, quad, cells, wanted, NULL, inner))
        return 0;
    reaches(frame, inner, cells, coarse, fine, beyond);
    for (int edge = 0; edge < 4; edge++)
        if (beyond[edge] < MIN_FINE_PX)
            fine[edge] = 0;
    if (!at_rim || !fit_edges(frame, inner, inverted, fine, fitted, &narrow) || narrow)
        memcpy(fitted, inner, sizeof inner);
    return 1;
}

/* Fit a quadrilateral, off by less than about a quarter of a cell, to a tag of which something covers an edge: exactly
   to the edges that are seen, and as for the others, to those between its cells. Returns 0 if too few are seen, or if
   they contradict the cells, as the edge of what covers the tag does. */
static int fit_covered(const Image *frame, const Point quad[4], int inverted, int cells, const uint8_t *wanted,
                       Point fitted[4])
{
    Point found[4], measured[4];
    float coarse[4], fine[4], beyond[4];
    int seen[4], count = 0, narrow;
    reaches(frame, quad, cells, coarse, fine, beyond);
    for (int edge = 0; edge < 4; edge++) {
        float alone[4] = {0};
        alone[edge] = fine[edge];
        if (coarse[edge] < COARSE * LEAST_CELL_PX)
            return 0;
        seen[edge] = beyond[edge] >= MIN_FINE_PX && fit_edges(frame, quad, inverted, alone, found, &narrow) && !narrow;
        fine[edge] *= seen[edge];
        count += seen[edge];
    }
    return count >= LEAST_SEEN && fit_edges(frame, quad, inverted, fine, found, &narrow)
        && fit_edges(frame, found, inverted, fine, measured, &narrow)
        && fit_cells(frame, measured, cells, wanted, seen, fitted);
}

void unit5_fit_tags(const Image *frame, int count, const Point *quads, int cells, uint8_t *wanted, Point *fitted,
                    uint8_t *good, float *likeness, int samples, float *whole)
{
    for (int tag = 0; tag < count; tag++) {
        int narrow = 0, rim = 1;  /* its border is compared only if something covers it */
        const Point *quad = quads + 4 * tag;
        Point *found = fitted + 4 * tag;
        uint8_t *own = wanted + tag * cells * cells;
        if (whole && correlation(frame, quad, cells, own, 0, 1) < 0)
            for (int cell = 0; cell < cells * cells; cell++)
                own[cell] = 255 - own[cell];
        int inverted = own[0] > 127;
        good[tag] = fit_tag(frame, quad, inverted, cells, found, &narrow);
        const Point *first = good[tag] ? found : quad;
        float coarse[4], fine[4], beyond[4], least = reaches(frame, first, cells, coarse, fine, beyond);
        int at_rim = least < MIN_FINE_PX;
        if (!good[tag] || narrow || at_rim) {
            Point inner[4];
            if (fit_inner(frame, first, inverted, cells, own, at_rim, inner)) {
                if (!good[tag] && fit_covered(frame, inner, inverted, cells, own, found))
                    rim = 0;
                else
                    memcpy(found, inner, sizeof inner);
                good[tag] = 1;
            } else if (least < MIN_WITHIN_PX)
                good[tag] = 0;
        }
        if (!good[tag])
            memcpy(found, quad, 4 * sizeof(Point));
        likeness[tag] = correlation(frame, found, cells, own, rim, 1);
        if (whole)
            whole[tag] = correlation(frame, found, cells, own, 0, samples);
    }
}

void unit5_sample_cells(const Image *frame, int count, const Point *quads, int cells, int margin, float *gray)
{
    for (int number = 0; number < count; number++) {
        Homography to = homography_to(quads + 4 * number);
        for (int down = margin; down < cells - margin; down++)
            for (int right = margin; right < cells - margin; right++)
                *gray++ = gray_at(frame, mapped(&to, (right + 0.5f) / cells, (down + 0.5f) / cells));
    }
}

/* Whether the middle of a quadrilateral is near that of one of the others: nearer than half of its side. */
static int is_at_one(const Point quad[4], int count, const Point *others)
{
    Point sum = plus(plus(plus(quad[0], 1, quad[1]), 1, quad[2]), 1, quad[3]);
    for (int i = 0; i < count; i++) {
        const Point *other = others + 4 * i;
        Point off = minus(sum, plus(plus(plus(other[0], 1, other[1]), 1, other[2]), 1, other[3]));
        float around = 0;
        for (int side = 0; side < 4; side++)
            around += length(minus(other[(side + 1) % 4], other[side]));
        if (larger(fabsf(off.x), fabsf(off.y)) <= around / 2)
            return 1;
    }
    return 0;
}

int guess_tag(const Image *frame, const Point quad[4], int cells, float contrast)
{
    int is_white = 1, is_uneven = 1, is_margin = 1;
    float darkest = 255, lightest = 0;
    for (int place = 0; place < 12 && (is_white || is_uneven || is_margin); place++) {
        int side = place % 4, along = (place / 4 + 1) % 3;  /* the middles of all sides come first */
        float share = ACROSS + (1 - 2 * ACROSS) * along / 2;
        Point from = quad[side], other = quad[(side + 3) % 4];
        Point near = plus(from, share, minus(quad[(side + 1) % 4], from));
        Point across = minus(plus(other, share, minus(quad[(side + 2) % 4], other)), near);
        float inside = gray_at(frame, plus(near, 0.5f / cells, across));
        float outside = gray_at(frame, plus(near, -0.5f / cells, across));
        is_white &= inside > outside + contrast;
        is_uneven &= outside > inside + contrast;
        if (is_margin)
            is_margin = gray_at(frame, plus(near, 1.5f / (cells + 2), across))
                > gray_at(frame, plus(near, 0.5f / (cells + 2), across)) + contrast;
        darkest = smaller(darkest, outside);
        lightest = larger(lightest, outside);
        if (place == 3)
            is_uneven &= lightest > UNEVEN * darkest;
    }
    return is_white ? WHITE_TAG : is_margin ? MARGIN : is_uneven ? UNEVEN_TAG : 0;
}

void unit5_guess_tags(const Image *frame, int count, const Point *quads, int cells, int known_count, const Point *known,
                      float contrast, uint8_t *guesses)
{
    for (int number = 0; number < count; number++) {
        const Point *quad = quads + 4 * number;
        int is_known = is_at_one(quad, known_count, known);
        guesses[number] = is_known ? 0 : guess_tag(frame, quad, cells, contrast);
    }
}
