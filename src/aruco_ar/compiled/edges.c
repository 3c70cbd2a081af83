/* Fitting tags to the frame: where exactly their edges lie, and whether it is they.

   Each edge of a tag, black inside and white outside, is looked at along short
   lines across it, its profiles. How much of a profile is light says where the
   edge crosses it, to some hundredths of a pixel and however blurred it is.

   In C, since NumPy takes longer to be called a hundred times than all of this
   takes: it is done for some tags in each frame. See edges.py, which calls it. */
#include "frame.h"
#include "cells.h"

#define SAMPLES 12        /* profiles along each edge */
#define BEGIN 0.08f       /* of the edge, between which they lie: a corner's rounding stays out */
#define END 0.92f
#define PLACES 15         /* at which each profile is looked at */
#define ENDS (PLACES / 5) /* of these, which say how dark its inner end is and how light its outer */
/* How far to both sides of an edge a profile reaches, in cells: to find the edge
   and to place it. The latter not too far, or shading would bend what is
   straight; and where an edge is off by more than NEAR of that, it is found first. */
#define FIND 0.95f
#define PLACE 0.6f
#define NEAR 0.4f
#define MIN_FIND_PX 1.8f
#define MIN_PLACE_PX 1.2f
#define MAX_PLACE_PX 5.0f
#define SETTLED_PX 0.5f   /* a quadrilateral that was off by more is placed once more */
#define MAX_BENT 0.35f    /* of the reach, by which half of an edge's profiles may be off its line */
#define RIM 0.9f          /* of the contrast: as light as this is the rim, which may end within a profile */
#define STEADY 0.5f       /* of an edge's contrast, which most of its profiles have where the rim is narrow */

#define PART(sample) (BEGIN + (END - BEGIN) * (sample) / (SAMPLES - 1))
const int samples = SAMPLES;
const float parts[SAMPLES] = {PART(0), PART(1), PART(2), PART(3), PART(4), PART(5),
                              PART(6), PART(7), PART(8), PART(9), PART(10), PART(11)};

typedef struct { float middle, slope, off[SAMPLES]; } Line;

/* The number of the rank, from 0, of those sorted. */
static float ranked(const float *values, int count, int rank)
{
    float sorted[SAMPLES];
    for (int i = 0; i < count; i++) {
        int place = i;
        for (; place > 0 && sorted[place - 1] > values[i]; place--)
            sorted[place] = sorted[place - 1];
        sorted[place] = values[i];
    }
    return sorted[rank];
}

static float median(const float *values) { return ranked(values, SAMPLES, SAMPLES / 2); }

static float mean(const float *values, int count)
{
    float sum = 0;
    for (int i = 0; i < count; i++)
        sum += values[i];
    return sum / count;
}

/* The line middle + slope * arm through offsets along an edge, arm being how far each is from its middle. */
static Line line_through(const float *offset, const float *weight)
{
    float count = 0, first = 0, second = 0, sum = 0, leaning = 0;
    for (int i = 0; i < SAMPLES; i++) {
        float arm = parts[i] - (BEGIN + END) / 2;
        count += weight[i];
        first += weight[i] * arm;
        second += weight[i] * arm * arm;
        sum += weight[i] * offset[i];
        leaning += weight[i] * offset[i] * arm;
    }
    Line line;
    line.slope = (count * leaning - first * sum) / (count * second - first * first + 1e-9f);
    line.middle = (sum - line.slope * first) / count;
    for (int i = 0; i < SAMPLES; i++)
        line.off[i] = fabsf(offset[i] - line.middle - line.slope * (parts[i] - (BEGIN + END) / 2));
    return line;
}

/* Paper may be cut close to the tag, and what is beyond be of any shade: where the rim ends within the profiles
   of an edge, from which place it begins and before which it has ended. 0 where it reaches to their ends. */
static int narrow_rim(float gray[SAMPLES][PLACES], float dark, int *begins, int *ended)
{
    float typical[PLACES] = {0}, lightest = 0;
    for (int place = 0; place < PLACES; place++) {
        for (int i = 0; i < SAMPLES; i++)
            typical[place] += gray[i][place] * (1.0f / SAMPLES);
        lightest = larger(lightest, typical[place]);
    }
    float light = dark + RIM * (lightest - dark);
    if (lightest <= dark || typical[PLACES - 1] >= light)
        return 0;
    for (*begins = 0; typical[*begins] < light; ++*begins) {}
    for (*ended = *begins; typical[*ended] >= light; ++*ended) {}
    return 1;
}

/* Where an edge crosses its profiles, in pixels outward; 0 where it cannot be told. */
static int offsets(float gray[SAMPLES][PLACES], float reach, float offset[SAMPLES], int *narrow_rims)
{
    float ends[SAMPLES], contrast[SAMPLES];
    for (int i = 0; i < SAMPLES; i++)
        ends[i] = mean(gray[i], ENDS);
    float dark = median(ends);  /* black is the same along an edge; white has shades */
    int begins = PLACES - ENDS, ended = PLACES, narrow = narrow_rim(gray, dark, &begins, &ended);
    *narrow_rims |= narrow;
    for (int i = 0; i < SAMPLES; i++) {
        contrast[i] = mean(gray[i] + begins, ended - begins) - dark;
        float light = PLACES - ended, scale = 1 / larger(contrast[i], 1);
        for (int place = 0; place < ended; place++)
            /* What is far lighter or darker than both ends belongs to something else. */
            light += larger(-MAX_BEYOND, smaller((gray[i][place] - dark) * scale, 1 + MAX_BEYOND));
        offset[i] = (PLACES / 2.0f - light) * reach * 2 / (PLACES - 1);
    }
    float typical = median(contrast);
    /* Of noise, too, some place is the lightest, but not along all of an edge. */
    return typical > MIN_CONTRAST && (!narrow || ranked(contrast, SAMPLES, SAMPLES / 4) > STEADY * typical);
}

/* Fit one quadrilateral, reaching as many pixels far across each edge; 0 where one of these is not seen.
   Also whether a rim ends within that reach. */
static int fit_edges(const Frame *frame, const Point quad[4], const float reach[4], Point fitted[4],
                     int *narrow)
{
    Point first[4], along[4];
    *narrow = 0;
    for (int edge = 0; edge < 4; edge++) {
        along[edge] = minus(quad[(edge + 1) % 4], quad[edge]);
        float size = larger(length(along[edge]), 1e-6f);
        Point outward = {along[edge].y / size, -along[edge].x / size};
        float gray[SAMPLES][PLACES], offset[SAMPLES], weight[SAMPLES];
        for (int i = 0; i < SAMPLES; i++) {
            Point on_edge = plus(quad[edge], parts[i], along[edge]);
            for (int place = 0; place < PLACES; place++) {
                float across = reach[edge] * (place * 2.0f / (PLACES - 1) - 1);
                gray[i][place] = look(frame, plus(on_edge, across, outward));
            }
            weight[i] = 1;
        }
        if (!offsets(gray, reach[edge], offset, narrow))
            return 0;
        /* A straight line through the offsets, and once more without those unlike the rest. */
        Line line = line_through(offset, weight);
        float most = 3 * median(line.off) + 0.01f * reach[edge];
        for (int i = 0; i < SAMPLES; i++)
            weight[i] = line.off[i] <= most;
        line = line_through(offset, weight);
        if (median(line.off) >= MAX_BENT * reach[edge])
            return 0;
        first[edge] = plus(quad[edge], line.middle - line.slope * (BEGIN + END) / 2, outward);
        along[edge] = plus(along[edge], line.slope, outward);
    }
    for (int edge = 0; edge < 4; edge++) {  /* each corner is where its edge crosses the one before */
        int before = (edge + 3) % 4;
        float crossed = cross(along[before], along[edge]);
        crossed = fabsf(crossed) < 1e-6f ? 1e-6f : crossed;
        float far = cross(minus(first[edge], first[before]), along[edge]) / crossed;
        fitted[edge] = plus(first[before], far, along[before]);
        if (!(length(minus(fitted[edge], quad[edge])) < 3 * reach[edge]))
            return 0;
    }
    return 1;
}

/* Put a quadrilateral onto the edges of a tag so many cells wide; 0 where one of these is not seen. */
static int fit_tag(const Frame *frame, const Point quad[4], int cells, Point fitted[4], int *narrow)
{
    float find[4], place[4];
    /* Seen from the side, a tag's cells are much narrower across its upright edges than along them. */
    float area = fabsf(cross(minus(quad[2], quad[0]), minus(quad[3], quad[1]))) / 2;
    for (int edge = 0; edge < 4; edge++) {
        float cell = area / larger(length(minus(quad[(edge + 1) % 4], quad[edge])), 1e-6f) / cells;
        find[edge] = larger(FIND * cell, MIN_FIND_PX);
        place[edge] = smaller(larger(PLACE * cell, MIN_PLACE_PX), MAX_PLACE_PX);
    }
    int near = fit_edges(frame, quad, place, fitted, narrow), settled = 1;
    for (int corner = 0; near && corner < 4; corner++) {
        float moved = length(minus(fitted[corner], quad[corner]));
        near = moved < NEAR * place[corner];
        settled &= moved < SETTLED_PX;
    }
    if (near && settled)
        return 1;
    Point found[4], placed[4];
    if (near) {
        memcpy(found, fitted, sizeof found);
        return fit_edges(frame, found, place, fitted, narrow);
    }
    return fit_edges(frame, quad, find, found, narrow) && fit_edges(frame, found, place, placed, narrow)
        && fit_edges(frame, placed, place, fitted, narrow);
}

/* The correlation of what is between four corners with a tag's cells, (cells, cells), without its border. */
static float likeness_of(const Frame *frame, const Point quad[4], int cells, const uint8_t *wanted)
{
    double sum = 0, squares = 0, wanted_sum = 0, wanted_squares = 0, products = 0;
    int count = (cells - 2) * (cells - 2);
    for (int row = 1; row < cells - 1; row++)
        for (int column = 1; column < cells - 1; column++) {
            float x = (column + 0.5f) / cells, y = (row + 0.5f) / cells;
            Point upper = plus(quad[0], x, minus(quad[1], quad[0]));
            Point lower = plus(quad[3], x, minus(quad[2], quad[3]));
            double gray = look(frame, plus(upper, y, minus(lower, upper))), cell = wanted[row * cells + column];
            sum += gray;
            squares += gray * gray;
            wanted_sum += cell;
            wanted_squares += cell * cell;
            products += gray * cell;
        }
    double spread = (squares - sum * sum / count) * (wanted_squares - wanted_sum * wanted_sum / count);
    return (products - sum * wanted_sum / count) / sqrt(fmax(spread, 1e-6));
}

/* See fit_tags in edges.py. A row of the frame has so many bytes, wherever it ends. */
void fit_tags(const uint8_t *pixels, int64_t row, int width, int height, int channels, int count,
              const float *quads, int cells, const uint8_t *wanted, float *fitted, uint8_t *good,
              float *likeness)
{
    Frame frame = {pixels, row, width, height, channels};
    for (int tag = 0; tag < count; tag++) {
        int narrow = 0;
        const Point *quad = (const Point *)quads + 4 * tag;
        Point *found = (Point *)fitted + 4 * tag;
        good[tag] = fit_tag(&frame, quad, cells, found, &narrow);
        if (!good[tag] || narrow) {
            Point inner[4];
            if (fit_cells(&frame, good[tag] ? found : quad, cells, wanted + tag * cells * cells, inner)) {
                good[tag] = 1;
                memcpy(found, inner, sizeof inner);
            }
        }
        if (!good[tag])
            memcpy(found, quad, 4 * sizeof(Point));
        likeness[tag] = likeness_of(&frame, found, cells, wanted + tag * cells * cells);
    }
}
