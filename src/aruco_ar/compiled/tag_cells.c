/* Fitting a tag to the edges between its own cells.

   With a narrow margin, the tag's outer edges are unreliable: blur darkens the
   margin, and what is beyond it shines in. The edges between dark and light
   cells are better. They are at least a cell apart, and since all cells around
   them are known, the effect of blur can be computed.

   A profile is a row of samples from the middle of one cell to the middle of
   the next one. */
#include "tag_cells.h"

#define PROFILE 9        /* samples of a profile */
#define UNKNOWNS 9       /* the eight coordinates of the corners, and the blooming of light cells into dark ones */
#define STEPS 6          /* number of steps of the fit */
#define BLUR 0.15f       /* first estimate of the blur's standard deviation, in cells */
#define MIN_BLUR 0.05f
#define MAX_BLUR 0.6f
#define MIN_SLOPE 0.05f  /* least slope in the middle of a profile, as a share of the contrast */
/* Distances from the expected edge, relative to a profile's length: an edge farther off is another one; the
   largest mean while fitting; the largest mean after the last step. It may be larger if some of the tag's own edges
   stay as they are, since a ghost image, as of a lens or of sharpening, shifts the edges of all cells. */
#define MAX_OFF 0.4f
#define MAX_MEAN_OFF 0.2f
#define MAX_FINAL_OFF 0.03f
#define MAX_EXACT_OFF 0.06f
#define MIN_SEEN 0.9f    /* share of the edges between cells that must be found; otherwise something covers the tag */
#define MIN_EDGES 8
#define MAX_MOVED 1.5f   /* a corner is not moved farther than this, in cells */
#define RIDGE 1e-3       /* added to the diagonal, so that poorly determined unknowns stay small */
#define KEPT 1e4         /* the weight of an edge that is known, compared with one profile */

/* How far beyond a profile's middle it crosses from dark to light, or back, in samples. Also its contrast, which
   is the difference between its ends, and the slope in its middle. */
static float crossing(const float gray[PROFILE], float *contrast, float *slope)
{
    float begin = (gray[0] + gray[1]) / 2, share = 0;
    *contrast = (gray[PROFILE - 1] + gray[PROFILE - 2]) / 2 - begin;
    *slope = gray[PROFILE / 2 + 1] - gray[PROFILE / 2 - 1];
    float scale = fabsf(*contrast) > 1e-6f ? 1 / *contrast : 0;
    for (int sample = 0; sample < PROFILE; sample++)
        share += larger(-MAX_BEYOND, smaller((gray[sample] - begin) * scale, 1 + MAX_BEYOND));
    return PROFILE / 2.0f - share;
}

/* The part of a Gaussian with mean 0 and that deviation which is below a value. */
static float below(float value, float deviation) { return 0.5f + 0.5f * erff(value / deviation * 0.70710678f); }

/* The weights of four cells in each sample of a profile: of the two cells, the one before them, and the one
   after them. ``blur``: its standard deviation, cells. */
static void blurred(float blur, float weights[PROFILE][4])
{
    for (int sample = 0; sample < PROFILE; sample++) {
        float at = sample / (PROFILE - 1.0f), before = 0;
        for (int cell = 0; cell < 4; cell++) {
            float until = cell == 3 ? 1 : below(cell - 0.5f - at, blur);
            weights[sample][cell] = until - before;
            before = until;
        }
    }
}

static float shade(const uint8_t *wanted, int cells, int row, int column)
{
    int inside = row >= 0 && column >= 0 && row < cells && column < cells;
    return inside ? wanted[row * cells + column] / 255.0f : 0.5f;  /* what is around a tag is unknown */
}

/* The profile that is expected from a cell to the next one, to the right or below. ``beside``: the weight of the
   cells on each side of the profile. */
static void expected(const uint8_t *wanted, int cells, int row, int column, int down, float weights[PROFILE][4],
                     float beside, float gray[PROFILE])
{
    float along[4];
    for (int cell = 0; cell < 4; cell++) {
        int y = row + (down ? cell - 1 : 0), x = column + (down ? 0 : cell - 1);
        along[cell] = (1 - 2 * beside) * shade(wanted, cells, y, x)
            + beside * (shade(wanted, cells, y - !down, x - down) + shade(wanted, cells, y + !down, x + down));
    }
    for (int sample = 0; sample < PROFILE; sample++)
        gray[sample] = weights[sample][0] * along[0] + weights[sample][1] * along[1] + weights[sample][2] * along[2]
            + weights[sample][3] * along[3];
}

/* Solve the equations in place by Cholesky's method. The matrix is symmetric and positive definite. */
static void solve(double matrix[UNKNOWNS][UNKNOWNS], double vector[UNKNOWNS])
{
    for (int i = 0; i < UNKNOWNS; i++)
        for (int j = 0; j <= i; j++) {
            double sum = matrix[i][j];
            for (int k = 0; k < j; k++)
                sum -= matrix[i][k] * matrix[j][k];
            matrix[i][j] = i == j ? sqrt(sum > 1e-12 ? sum : 1e-12) : sum / matrix[j][j];
        }
    for (int i = 0; i < UNKNOWNS; i++) {
        for (int k = 0; k < i; k++)
            vector[i] -= matrix[i][k] * vector[k];
        vector[i] /= matrix[i][i];
    }
    for (int i = UNKNOWNS - 1; i >= 0; i--) {
        for (int k = i + 1; k < UNKNOWNS; k++)
            vector[i] -= matrix[k][i] * vector[k];
        vector[i] /= matrix[i][i];
    }
}

Homography homography_to(const Point quad[4])
{
    Point one = minus(quad[1], quad[2]), other = minus(quad[3], quad[2]);
    Point rest = minus(minus(quad[0], quad[1]), minus(quad[3], quad[2]));
    float area = cross(one, other);
    area = fabsf(area) < 1e-6f ? 1e-6f : area;
    float g = cross(rest, other) / area, h = cross(one, rest) / area;
    return (Homography){plus(minus(quad[1], quad[0]), g, quad[1]), plus(minus(quad[3], quad[0]), h, quad[3]), quad[0],
                        g, h};
}

/* Add to the equations that the corners of an edge stay on it. */
static void keep_edge(const Point quad[4], int edge, double matrix[UNKNOWNS][UNKNOWNS])
{
    Point along = minus(quad[(edge + 1) % 4], quad[edge]);
    float size = larger(length(along), 1e-6f);
    const double x = along.y / size, y = -along.x / size;  /* across the edge */
    for (int end = 0; end < 2; end++) {
        int i = 2 * ((edge + end) % 4);
        matrix[i][i] += KEPT * x * x;
        matrix[i + 1][i] += KEPT * x * y;
        matrix[i + 1][i + 1] += KEPT * y * y;
    }
}

/* Whether a cell is at an edge of the tag that is not known exactly, so that something may cover it. */
static int may_be_covered(const int exact[4], int cells, int row, int column)
{
    return (row == 0 && !exact[0]) || (column == cells - 1 && !exact[1]) || (row == cells - 1 && !exact[2])
        || (column == 0 && !exact[3]);
}

int fit_cells(const Image *frame, const Point quad[4], int cells, const uint8_t *wanted, const int exact[4],
              Point fitted[4])
{
    float blur[2] = {BLUR, BLUR};  /* in cells, to the right and down */
    memcpy(fitted, quad, 4 * sizeof(Point));
    for (int step = 0; step < STEPS; step++) {
        double matrix[UNKNOWNS][UNKNOWNS] = {{0}}, vector[UNKNOWNS] = {0};
        Homography to = homography_to(fitted);
        int edges = 0, found = 0;
        float sum_off = 0, next_blur[2];
        for (int down = 0; down < 2; down++) {
            float weights[PROFILE][4], beside = below(-0.5f, blur[!down]), slopes[2] = {0}, contrasts[2] = {0};
            blurred(blur[down], weights);
            for (int row = 0; row < cells - down; row++)
                for (int column = 0; column < cells - 1 + down; column++) {
                    int here = wanted[row * cells + column] > 127;
                    if (here == (wanted[(row + down) * cells + column + 1 - down] > 127))
                        continue;
                    if (exact && (may_be_covered(exact, cells, row, column)
                                  || may_be_covered(exact, cells, row + down, column + 1 - down)))
                        continue;
                    edges++;
                    float x = (column + 0.5f) / cells, y = (row + 0.5f) / cells, further = 1.0f / cells;
                    Point first = mapped(&to, x, y);
                    Point second = mapped(&to, x + (down ? 0 : further), y + (down ? further : 0));
                    Point across = minus(second, first);
                    float gray[PROFILE], contrast, slope, should_contrast, should_slope;
                    for (int sample = 0; sample < PROFILE; sample++)
                        gray[sample] = gray_at(frame, plus(first, sample / (PROFILE - 1.0f), across));
                    float off = crossing(gray, &contrast, &slope), sign = here ? -1 : 1;
                    if (sign * contrast < MIN_CONTRAST)
                        continue;
                    expected(wanted, cells, row, column, down, weights, beside, gray);
                    off -= crossing(gray, &should_contrast, &should_slope);
                    off /= PROFILE - 1;
                    if (!(fabsf(off) <= MAX_OFF))  /* also true for NaN */
                        continue;
                    found++;
                    sum_off += fabsf(off);
                    slopes[0] += sign * slope;
                    contrasts[0] += sign * contrast;
                    slopes[1] += sign * should_slope;
                    contrasts[1] += sign * should_contrast;
                    float size = larger(length(across), 1e-6f);
                    x += down ? 0 : further / 2;
                    y += down ? further / 2 : 0;
                    float shares[4] = {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
                    double moves[UNKNOWNS];
                    for (int i = 0; i < 8; i++)
                        moves[i] = shares[i / 2] * (i % 2 ? across.y : across.x) / size;
                    moves[8] = sign;  /* blooming shifts all edges toward the dark cells alike */
                    for (int i = 0; i < UNKNOWNS; i++) {
                        for (int j = 0; j <= i; j++)
                            matrix[i][j] += moves[i] * moves[j];
                        vector[i] += moves[i] * off * size;
                    }
                }
            /* If profiles are steeper than expected, there is less blur than assumed. */
            float seen = slopes[0] / larger(contrasts[0], 1e-6f);
            float should = slopes[1] / larger(contrasts[1], 1e-6f);
            float estimate = blur[down] * should / larger(seen, MIN_SLOPE);
            next_blur[down] = larger(MIN_BLUR, smaller(estimate, MAX_BLUR));
        }
        float most = step < STEPS - 1 ? MAX_MEAN_OFF : exact ? MAX_EXACT_OFF : MAX_FINAL_OFF;
        if (found < MIN_SEEN * edges || found < MIN_EDGES || sum_off > most * found)
            return 0;
        memcpy(blur, next_blur, sizeof blur);
        for (int i = 0; i < UNKNOWNS; i++)
            matrix[i][i] += RIDGE;
        for (int edge = 0; edge < 4; edge++)
            if (exact && exact[edge])
                keep_edge(quad, edge, matrix);
        solve(matrix, vector);
        for (int corner = 0; corner < 4; corner++)
            fitted[corner] = plus(fitted[corner], 1, (Point){vector[2 * corner], vector[2 * corner + 1]});
    }
    for (int corner = 0; corner < 4; corner++)
        if (!(length(minus(fitted[corner], quad[corner])) * cells
              <= MAX_MOVED * length(minus(quad[(corner + 1) % 4], quad[corner]))))
            return 0;
    return 1;
}
