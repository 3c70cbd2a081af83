/* Aligning the wall, as it was learned, with the wall as it is seen: small patches of it, all at once, from coarse to
   fine. In each level, an image has half as many pixels in both directions as in the one below.

   This is the inverse compositional algorithm of S. Baker and I. Matthews, Lucas-Kanade 20 Years On, 2004, for a
   homography. Each patch is compared after its mean and its deviation are made equal, so that light does not matter.
   What does not look like the wall counts little. Blur does not move a patch, so it does little harm. */
#include <stdlib.h>

#include "algebra.h"
#include "unit5.h"
#include "vectors.h"

#define PATCH 12          /* pixels along each side of a patch */
#define PIXELS (PATCH * PATCH)
#define MOVES 8           /* infinitesimal homographies: two shifts, four linear ones, two that change perspective */
#define LEVELS 4
#define NOISE 3.0f        /* gray levels: a patch with this deviation counts half */
#define MIN_DEVIATION 0.5f /* gray levels: a patch with less has nothing to compare */
#define DAMPING 1e-3      /* added to the diagonal, as a share of its mean, so that unknowns stay small */
#define CONVERGED_PX 0.005 /* a smaller step is the last one */

/* A patch of the wall, as it was learned, with mean 0 and deviation 1. ``slopes``: across and down, which fade toward
   the rim, so that what blur brings in from beyond it counts little. ``matrix``: the sums of the slopes' products:
   across * across, across * down, and down * down; all 0 if there is nothing to compare. ``sums``: of each slope;
   ``own``: of each slope times gray. */
typedef struct { float gray[PIXELS], slopes[2][PIXELS], matrix[3], sums[2], own[2]; } Patch;

/* What may change in each level: the first moves of all, and the most steps. */
static const struct { int freedom, steps; } levels[LEVELS] = {{8, 8}, {8, 8}, {6, 8}, {2, 10}};

const int unit5_wall_levels = LEVELS, unit5_patch_width = PATCH, unit5_patch_size = sizeof(Patch) / sizeof(float);

typedef struct { int width, height; float *pixels; } Level;

/* Four pixels side by side, anywhere in memory. */
typedef Four Pixels __attribute__((aligned(4), may_alias));
_Static_assert(PATCH % 4 == 0, "pixels are computed by fours");

/* Make all levels of an image of floats, in which the first one stays. Returns NULL, or what is to be freed. */
static float *make_levels(float *image, int width, int height, Level made[LEVELS])
{
    float *others = malloc(((int64_t)width * height / 3 + 1) * sizeof *others), *next = others;
    made[0] = (Level){width, height, image};
    for (int level = 1; level < LEVELS && others; level++) {
        const Level *from = made + level - 1;
        made[level] = (Level){from->width / 2, from->height / 2, next};
        for (int y = 0; y < made[level].height; y++) {
            const float *row = from->pixels + 2 * (int64_t)y * from->width, *below = row + from->width;
            for (int x = 0; x < made[level].width; x++)
                *next++ = (row[2 * x] + row[2 * x + 1] + below[2 * x] + below[2 * x + 1]) / 4;
        }
    }
    return others;
}

/* The pixel at a position: the middle is (0, 0), and the left and right edges are at -1 and 1. */
static Point pixel_of(const Level *image, const double at[2])
{
    float half = image->width / 2.0f;
    return (Point){half * ((float)at[0] + 1) - 0.5f, half * (float)at[1] + (image->height - 1) / 2.0f};
}

/* The gray at a point. Beyond the image, its edge goes on. */
static float gray_of(const Level *image, float x, float y)
{
    x = within(x, image->width - 1);
    y = within(y, image->height - 1);
    int left = (int)x, top = (int)y, right = left + (left + 1 < image->width), below = top + (top + 1 < image->height);
    const float *upper = image->pixels + (int64_t)top * image->width;
    const float *lower = image->pixels + (int64_t)below * image->width;
    float first = upper[left] + (x - left) * (upper[right] - upper[left]);
    return first + (y - top) * (lower[left] + (x - left) * (lower[right] - lower[left]) - first);
}

/* The gray of the patch around a point. */
static void take(const Level *image, Point middle, float gray[PIXELS])
{
    int width = image->width;
    float x = middle.x - (PATCH - 1) / 2.0f, y = middle.y - (PATCH - 1) / 2.0f;
    if (!(x >= 0 && y >= 0 && x + PATCH < width && y + PATCH < image->height)) {
        for (int i = 0; i < PIXELS; i++)
            gray[i] = gray_of(image, x + i % PATCH, y + i / PATCH);
        return;
    }
    int left = (int)x, top = (int)y;
    float across = x - left, down = y - top;
    const float *row = image->pixels + (int64_t)top * width + left;
    Four upper[PATCH / 4];
    for (int j = 0; j <= PATCH; j++, row += width)
        for (int i = 0; i < PATCH / 4; i++) {
            Four first = *(const Pixels *)(row + 4 * i), next = *(const Pixels *)(row + 4 * i + 1);
            Four here = first + across * (next - first);
            if (j > 0) {
                *(Pixels *)gray = upper[i] + down * (here - upper[i]);
                gray += 4;
            }
            upper[i] = here;
        }
}

/* Make the mean 0 and the deviation 1. Returns the deviation that it was. */
static float normalize(float gray[PIXELS])
{
    Pixels *fours = (Pixels *)gray;
    Four sums = {0}, squares = {0};
    for (int i = 0; i < PIXELS / 4; i++)
        sums += fours[i];
    float mean = sum_of(sums) / PIXELS;
    for (int i = 0; i < PIXELS / 4; i++) {
        fours[i] -= mean;
        squares += fours[i] * fours[i];
    }
    float deviation = sqrtf(sum_of(squares) / PIXELS), scale = 1 / larger(deviation, MIN_DEVIATION);
    for (int i = 0; i < PIXELS / 4; i++)
        fours[i] *= scale;
    return deviation;
}

static void learn_patch(const Level *image, Point at, Patch *patch)
{
    float sides[2][2][PIXELS];  /* half a pixel to the left and to the right, above and below */
    take(image, at, patch->gray);
    for (int side = 0; side < 2; side++) {
        take(image, (Point){at.x + side - 0.5f, at.y}, sides[0][side]);
        take(image, (Point){at.x, at.y + side - 0.5f}, sides[1][side]);
    }
    float deviation = normalize(patch->gray), scale = deviation < MIN_DEVIATION ? 0 : 1 / deviation;
    memset(patch->matrix, 0, sizeof patch->matrix);
    memset(patch->sums, 0, sizeof patch->sums);
    memset(patch->own, 0, sizeof patch->own);
    for (int i = 0; i < PIXELS; i++) {
        float across = scale * (sides[0][1][i] - sides[0][0][i]), down = scale * (sides[1][1][i] - sides[1][0][i]);
        float x = (2 * (i % PATCH) + 1.0f) / PATCH - 1, y = (2 * (i / PATCH) + 1.0f) / PATCH - 1;
        float fading = (1 - x * x) * (1 - y * y);
        patch->slopes[0][i] = fading * across;
        patch->slopes[1][i] = fading * down;
        patch->matrix[0] += fading * across * across;
        patch->matrix[1] += fading * across * down;
        patch->matrix[2] += fading * down * down;
        for (int way = 0; way < 2; way++) {
            patch->sums[way] += patch->slopes[way][i];
            patch->own[way] += patch->slopes[way][i] * patch->gray[i];
        }
    }
}

int unit5_learn_patches(float *image, int width, int height, int count, const double *points, float *patches)
{
    Level made[LEVELS];
    float *others = make_levels(image, width, height, made);
    Patch *patch = (Patch *)patches;
    for (int level = 0; level < LEVELS && others; level++)
        for (int i = 0; i < count; i++)
            learn_patch(made + level, pixel_of(made + level, points + 2 * i), patch++);
    free(others);
    return others != NULL;
}

/* What is seen in the place of a patch. ``pull``: the sums of the slopes times what is seen beyond the patch. */
typedef struct { float likeness, deviation, pull[2]; } Seen;

static Seen compare_patch(const Level *image, const Patch *patch, Point at)
{
    float gray[PIXELS];
    take(image, at, gray);
    /* Relative to one pixel, so that the sum of the squares stays small, and exact. */
    const float base = gray[0];
    const Pixels *own = (const Pixels *)patch->gray, *right = (const Pixels *)patch->slopes[0];
    const Pixels *below = (const Pixels *)patch->slopes[1], *here = (const Pixels *)gray;
    Four sums = {0}, squares = {0}, product = {0}, across = {0}, down = {0};
    for (int i = 0; i < PIXELS / 4; i++) {
        Four value = here[i] - base;
        sums += value;
        squares += value * value;
        product += value * own[i];
        across += value * right[i];
        down += value * below[i];
    }
    float mean = sum_of(sums) / PIXELS, deviation = sqrtf(larger(sum_of(squares) / PIXELS - mean * mean, 0));
    float scale = 1 / larger(deviation, MIN_DEVIATION);  /* as in normalize */
    Seen seen = {.deviation = deviation};
    seen.pull[0] = scale * (sum_of(across) - mean * patch->sums[0]) - patch->own[0];
    seen.pull[1] = scale * (sum_of(down) - mean * patch->sums[1]) - patch->own[1];
    if (patch->matrix[0] + patch->matrix[2] > 0 && deviation >= MIN_DEVIATION)
        seen.likeness = scale * sum_of(product) / PIXELS;
    return seen;
}

/* How many pixels a patch alone is off. */
static void find_off(const Patch *patch, const Seen *seen, float off[2])
{
    const float *m = patch->matrix, *pull = seen->pull;
    float area = m[0] * m[2] - m[1] * m[1], share = area > 1e-6f ? 1 / area : 0;
    off[0] = share * (m[2] * pull[0] - m[1] * pull[1]);
    off[1] = share * (m[0] * pull[1] - m[1] * pull[0]);
}

/* What all patches together ask for: the equations normal * move = pull. */
typedef struct { double normal[MOVES][MOVES], pull[MOVES]; } Equations;

/* Add what a patch at a place asks for. ``half``: of the image's width, pixels. */
static void add_patch(const Patch *patch, const Seen *seen, const double place[2], int freedom, double weight,
                      double half, Equations *all)
{
    double x = place[0], y = place[1];
    const double across[MOVES] = {1, 0, x, 0, y, 0, x * x, x * y}, down[MOVES] = {0, 1, 0, x, 0, y, x * y, y * y};
    for (int a = 0; a < freedom; a++) {
        double right = weight * half * half * (patch->matrix[0] * across[a] + patch->matrix[1] * down[a]);
        double below = weight * half * half * (patch->matrix[1] * across[a] + patch->matrix[2] * down[a]);
        for (int b = 0; b <= a; b++)
            all->normal[a][b] += right * across[b] + below * down[b];
        all->pull[a] += weight * half * (across[a] * seen->pull[0] + down[a] * seen->pull[1]);
    }
}

/* Solve the equations for a move by the first ``freedom`` homographies. Returns its length, or -1 if there is none. */
static double solve_for(const Equations *all, int freedom, double move[MOVES])
{
    double matrix[MOVES * MOVES], trace = 0;
    for (int i = 0; i < freedom; i++)
        trace += all->normal[i][i];
    for (int i = 0; i < freedom; i++)
        for (int j = 0; j <= i; j++)
            matrix[freedom * i + j] = all->normal[i][j] + (i == j ? DAMPING * trace / freedom : 0);
    if (!(trace > 0) || !factorize(matrix, freedom))
        return -1;
    memset(move, 0, MOVES * sizeof *move);
    memcpy(move, all->pull, freedom * sizeof *move);
    solve(matrix, freedom, move);
    return sqrt(dot(move, move, freedom));
}

/* Undo a small move before a homography. Returns 0 if that is not possible. */
static int move_back(const double move[MOVES], double warp[9])
{
    const double ahead[9] = {1 + move[2], move[4], move[0], move[3], 1 + move[5], move[1], -move[6], -move[7], 1};
    double back[9], moved[9];  /* the columns of the inverse, but for its scale */
    cross3(ahead + 3, ahead + 6, back);
    cross3(ahead + 6, ahead, back + 3);
    cross3(ahead, ahead + 3, back + 6);
    for (int i = 0; i < 9; i++)
        moved[i] = dot(warp + i / 3 * 3, back + i % 3 * 3, 3);
    if (!(fabs(moved[8]) > 1e-9))
        return 0;
    for (int i = 0; i < 9; i++)
        warp[i] = moved[i] / moved[8];
    return 1;
}

/* Align patches in one level; see unit5_align_patches. */
static void align_level(const Level *image, int count, const Patch *patches, const double *places,
                        const uint8_t *usable, int freedom, int steps, double warp[9], float *likeness, float *off)
{
    double half = image->width / 2.0, move[MOVES];
    for (int step = 0, is_last = 0; !is_last; step++) {
        Equations all = {{{0}}, {0}};
        for (int i = 0; i < count; i++) {
            if (!usable[i])
                continue;
            double at[2];
            map_point(warp, places[2 * i], places[2 * i + 1], at);
            Seen seen = compare_patch(image, patches + i, pixel_of(image, at));
            double square = seen.deviation * seen.deviation, weight = square / (square + NOISE * NOISE);
            if (freedom > 2)  /* at first, when all are far off, nothing is like the wall */
                weight *= seen.likeness > 0 ? seen.likeness * seen.likeness : 0;
            if (weight > 0)
                add_patch(patches + i, &seen, places + 2 * i, freedom, weight, half, &all);
            likeness[i] = seen.likeness;
            find_off(patches + i, &seen, off + 2 * i);
        }
        double size = step < steps ? solve_for(&all, freedom, move) : -1;
        is_last = size < 0 || !move_back(move, warp);
        steps = half * size < CONVERGED_PX ? step + 1 : steps;
    }
}

int unit5_align_patches(float *image, int width, int height, int count, const float *patches, const double *places,
                        const uint8_t *usable, int coarsest, int only_compare, double *warps, float *likeness,
                        float *off)
{
    Level made[LEVELS];
    float *others = make_levels(image, width, height, made);
    double warp[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int level = coarsest; level >= 0 && others; level--) {
        int64_t first = (int64_t)level * count;
        align_level(made + level, count, (const Patch *)patches + first, places, usable, levels[level].freedom,
                    only_compare ? 0 : levels[level].steps, warp, likeness + first, off + 2 * first);
        memcpy(warps + 9 * level, warp, sizeof warp);
    }
    free(others);
    return others != NULL;
}
