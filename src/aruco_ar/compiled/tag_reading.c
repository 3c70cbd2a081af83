/* Reading the cells of tags. */
#include <stdlib.h>

#include "tag_cells.h"
#include "unit5.h"

#define LEVELS 64        /* of gray, to find the threshold between dark and light */
#define MAX_LIGHT 0.5f   /* share of a tag's border that may be light; what else is seen is checked later */
#define MAX_MORE 4       /* a word with so many more wrong cells than can be corrected is not compared with the best */
#define MIN_MORE 0.5f    /* by how much the cells must be more like the best word than like another one, together */
#define MOST_CELLS (8 + 2 * 10)  /* of a tag, along a side */

enum { NO_TAG = -1, UNSURE = -2 };

/* The threshold between dark and light cells: halfway between the means of both classes, which are chosen by Otsu's
   method. ``apart``: how far apart these means are. */
static float threshold_of(const float *gray, int count, float *apart)
{
    const float width = 256.0f / LEVELS;
    int histogram[LEVELS] = {0};
    for (int cell = 0; cell < count; cell++)
        histogram[(int)(gray[cell] / width)]++;
    int sum = 0, below = 0, dark = 0;
    float most = 0, threshold = 0;
    *apart = 0;
    for (int level = 0; level < LEVELS; level++)
        sum += level * histogram[level];
    for (int level = 0; level < LEVELS - 1; level++) {
        below += histogram[level];
        dark += level * histogram[level];
        if (!histogram[level] || below == count)
            continue;
        float darker = (float)dark / below, lighter = (float)(sum - dark) / (count - below);
        float between = (lighter - darker) * (lighter - darker) * below * (count - below);
        if (between > most) {
            most = between;
            threshold = (darker + lighter + 1) / 2 * width;
            *apart = (lighter - darker) * width;
        }
    }
    return threshold;
}

/* The mean gray of each cell: four samples. */
static void sample(const Image *frame, const Point quad[4], int cells, float *gray)
{
    Homography to = homography_to(quad);
    float scale = 1.0f / cells;
    for (int row = 0; row < cells; row++)
        for (int column = 0; column < cells; column++) {
            float sum = 0;
            for (int part = 0; part < 4; part++)
                sum += gray_at(frame, mapped(&to, (column + (part & 1 ? 0.7f : 0.3f)) * scale,
                                             (row + (part & 2 ? 0.7f : 0.3f)) * scale));
            *gray++ = sum / 4;
        }
}

static int ones_in(uint64_t bits)
{
    bits -= bits >> 1 & 0x5555555555555555;
    bits = (bits & 0x3333333333333333) + (bits >> 2 & 0x3333333333333333);
    bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0f;
    return bits * 0x0101010101010101 >> 56;
}

/* What is seen of the cells within the border: bits, row by row, the first one lowest, and how sure each is, as a
   share of the contrast. ``light``: how many cells of the border are not black. */
typedef struct { uint64_t bits; float sure[64]; int light; } Word;

/* Returns 0 if there is no contrast, or the border is not black. */
static int read_word(const float *gray, int cells, int border, Word *word)
{
    float apart, threshold = threshold_of(gray, cells * cells, &apart);
    int count = 0, inside = cells - 2 * border;
    word->bits = word->light = 0;
    if (apart < MIN_CONTRAST)
        return 0;
    for (int row = 0; row < cells; row++)
        for (int column = 0; column < cells; column++) {
            float above = gray[row * cells + column] - threshold;
            if (row < border || column < border || row >= cells - border || column >= cells - border) {
                word->light += above >= 0;
            } else {
                word->sure[count] = fabsf(above) / apart;
                word->bits |= (uint64_t)(above >= 0) << count++;
            }
        }
    return word->light <= MAX_LIGHT * (cells * cells - inside * inside);
}

/* The number of the word of the dictionary that is most like what is seen, or NO_TAG if none is, or UNSURE if another
   one is almost as much. ``near``: room for the numbers of all words. ``wrong``: how many cells differ. */
static int find_word(const Word *word, int words, const uint64_t *dictionary, int corrected, int *near, int *wrong)
{
    int best = NO_TAG, count = 0;
    *wrong = corrected + 1;
    for (int other = 0; other < 4 * words; other++) {
        int differ = ones_in(word->bits ^ dictionary[other]);
        near[count] = other;
        count += differ <= corrected + MAX_MORE;
        if (differ < *wrong)
            *wrong = differ, best = other;
    }
    for (int number = 0; best >= 0 && number < count; number++) {
        uint64_t unlike = dictionary[near[number]] ^ dictionary[best], missed = word->bits ^ dictionary[best];
        float more = 0;
        for (int cell = 0; cell < 64; cell++)
            if (unlike >> cell & 1)
                more += missed >> cell & 1 ? -word->sure[cell] : word->sure[cell];
        if (unlike && more < MIN_MORE)
            return UNSURE;
    }
    return best;
}

static Point middle(const Point quad[4])
{
    return (Point){(quad[0].x + quad[1].x + quad[2].x + quad[3].x) / 4,
                   (quad[0].y + quad[1].y + quad[2].y + quad[3].y) / 4};
}

/* Which one of the quadrilaterals before this one is a tag in the same place, or -1. */
static int at_place_of(int number, const Point *quads, const int *ids)
{
    const Point *quad = quads + 4 * number;
    Point own = middle(quad);
    for (int other = 0; other < number; other++) {
        const Point *known = quads + 4 * other;
        if (ids[other] >= 0 && length(minus(own, middle(known))) < length(minus(known[1], known[0])) / 2)
            return other;
    }
    return -1;
}

int unit5_read_tags(const Image *frame, int count, Point *quads, int cells, int border, int words,
                    const uint64_t *dictionary, int corrected, float contrast, int *ids)
{
    int *doubts = malloc(count * sizeof *doubts + 1), *near = malloc((4 * words + 1) * sizeof *near);
    for (int number = 0; doubts && near && number < count; number++) {
        Point *quad = quads + 4 * number, seen[4];
        float gray[MOST_CELLS * MOST_CELLS];
        Word word;
        int wrong = 0, best = NO_TAG, other = at_place_of(number, quads, ids);
        ids[number] = UNSURE;
        if (other >= 0 && !doubts[other])
            continue;
        sample(frame, quad, cells, gray);
        int is_black = read_word(gray, cells, border, &word);
        if (!is_black && guess_tag(frame, quad, cells, contrast) == WHITE_TAG) {
            for (int cell = 0; cell < cells * cells; cell++)
                gray[cell] = 255 - gray[cell];
            is_black = read_word(gray, cells, border, &word);
        }
        if (is_black)
            best = find_word(&word, words, dictionary, corrected, near, &wrong);
        doubts[number] = word.light + wrong;
        if (other >= 0 && best >= 0) {  /* there are two readings, of which the better one counts */
            if (doubts[number] >= doubts[other])
                continue;
            ids[other] = UNSURE;
        }
        ids[number] = best < 0 ? best : best / 4;
        if (best < 0)
            continue;
        memcpy(seen, quad, sizeof seen);
        for (int corner = 0; corner < 4; corner++)
            quad[corner] = seen[(corner - best % 4 + 4) % 4];
    }
    int done = doubts && near;
    free(near);
    free(doubts);
    return done;
}
