/* Fitting a tag to the edges between its own cells.

   Where the paper ends close to the tag, its outer edges say little: blurred,
   a narrow rim is no longer white, and what is beyond shines into it. The edges
   between dark and light cells are a whole cell away from each other, and all
   that is around them is known, so also what blur does to them. */

#define PROFILE 9        /* places at which a profile between the middles of two cells is looked at */
#define UNKNOWNS 9       /* eight numbers of four corners, and how far light outshines dark */
#define STEPS 6          /* by which a tag is fitted */
#define BLUR 0.15f       /* cells, before anything is known about it */
#define MIN_BLUR 0.05f
#define MAX_BLUR 0.6f
#define MIN_SLOPE 0.05f  /* of the contrast, in the middle of a profile */
/* Of the way between the middles of two cells: farther off is none of their edge; so far off may edges be on
   average; and so far when all is fitted. */
#define MAX_OFF 0.4f
#define MAX_UNEVEN 0.2f
#define MAX_LEFT 0.03f
#define MIN_SEEN 0.9f    /* of all edges between cells: fewer are seen where something is before the tag */
#define MIN_EDGES 8
#define MAX_MOVED 1.5f   /* cells, of a corner */
#define RIDGE 1e-3       /* keeps what little is known about a tag's cells from meaning too much */

/* A profile between the middles of two cells: how many of its places beyond its middle it crosses from dark to
   light or back; also by how much it grows from end to end, and in its middle. */
static float crossing(const float gray[PROFILE], float *contrast, float *slope)
{
    float begin = (gray[0] + gray[1]) / 2, share = 0;
    *contrast = (gray[PROFILE - 1] + gray[PROFILE - 2]) / 2 - begin;
    *slope = gray[PROFILE / 2 + 1] - gray[PROFILE / 2 - 1];
    float scale = fabsf(*contrast) > 1e-6f ? 1 / *contrast : 0;
    for (int place = 0; place < PROFILE; place++)
        share += larger(-MAX_BEYOND, smaller((gray[place] - begin) * scale, 1 + MAX_BEYOND));
    return PROFILE / 2.0f - share;
}

/* Of a Gaussian of that deviation, the part below. */
static float below(float value, float deviation) { return 0.5f + 0.5f * erff(value / deviation * 0.70710678f); }

/* How much of each cell, from the one before the first to the one after the second, is seen at each place of a
   profile between the middles of two, blurred so much, in cells. */
static void blurred(float blur, float parts[PROFILE][4])
{
    for (int place = 0; place < PROFILE; place++) {
        float at = place / (PROFILE - 1.0f), before = 0;
        for (int cell = 0; cell < 4; cell++) {
            float until = cell == 3 ? 1 : below(cell - 0.5f - at, blur);
            parts[place][cell] = until - before;
            before = until;
        }
    }
}

static float shade(const uint8_t *wanted, int cells, int row, int column)
{
    int inside = row >= 0 && column >= 0 && row < cells && column < cells;
    return inside ? wanted[row * cells + column] / 255.0f : 0.5f;  /* nobody knows what is around a tag */
}

/* The profile that a tag's cells give, from that cell to the next to the right or below. */
static void expected(const uint8_t *wanted, int cells, int row, int column, int down, float parts[PROFILE][4],
                     float beside, float gray[PROFILE])
{
    float along[4];
    for (int cell = 0; cell < 4; cell++) {
        int y = row + (down ? cell - 1 : 0), x = column + (down ? 0 : cell - 1);
        along[cell] = (1 - 2 * beside) * shade(wanted, cells, y, x)
            + beside * (shade(wanted, cells, y - !down, x - down) + shade(wanted, cells, y + !down, x + down));
    }
    for (int place = 0; place < PROFILE; place++)
        gray[place] = parts[place][0] * along[0] + parts[place][1] * along[1] + parts[place][2] * along[2]
            + parts[place][3] * along[3];
}

/* Solve eight equations, the matrix being symmetric and positive: by Cholesky's method, in place. */
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

/* The place in a quadrilateral of (x, y) of the unit square, by their homography; see homography_to. */
static Point place_in(const Point quad[4], float x, float y)
{
    Point one = minus(quad[1], quad[2]), other = minus(quad[3], quad[2]);
    Point rest = minus(minus(quad[0], quad[1]), minus(quad[3], quad[2]));
    float area = cross(one, other), g, h;
    area = fabsf(area) < 1e-6f ? 1e-6f : area;
    g = cross(rest, other) / area;
    h = cross(one, rest) / area;
    float depth = g * x + h * y + 1;
    return (Point){((quad[1].x - quad[0].x + g * quad[1].x) * x + (quad[3].x - quad[0].x + h * quad[3].x) * y
                    + quad[0].x) / depth,
                   ((quad[1].y - quad[0].y + g * quad[1].y) * x + (quad[3].y - quad[0].y + h * quad[3].y) * y
                    + quad[0].y) / depth};
}

/* Fit a quadrilateral to the edges between dark and light cells within a tag, which need no rim; 0 where too
   many of them are not seen. */
static int fit_cells(const Frame *frame, const Point quad[4], int cells, const uint8_t *wanted, Point fitted[4])
{
    float blur[2] = {BLUR, BLUR};  /* in cells, to the right and down */
    memcpy(fitted, quad, 4 * sizeof(Point));
    for (int step = 0; step < STEPS; step++) {
        double matrix[UNKNOWNS][UNKNOWNS] = {{0}}, vector[UNKNOWNS] = {0};
        int edges = 0, found = 0;
        float sum_off = 0, next_blur[2];
        for (int down = 0; down < 2; down++) {
            float parts[PROFILE][4], beside = below(-0.5f, blur[!down]), slopes[2] = {0}, contrasts[2] = {0};
            blurred(blur[down], parts);
            for (int row = 0; row < cells - down; row++)
                for (int column = 0; column < cells - 1 + down; column++) {
                    int here = wanted[row * cells + column] > 127;
                    if (here == (wanted[(row + down) * cells + column + 1 - down] > 127))
                        continue;
                    edges++;
                    float x = (column + 0.5f) / cells, y = (row + 0.5f) / cells, further = 1.0f / cells;
                    Point first = place_in(fitted, x, y);
                    Point second = place_in(fitted, x + (down ? 0 : further), y + (down ? further : 0));
                    Point across = minus(second, first);
                    float gray[PROFILE], contrast, slope, should_contrast, should_slope;
                    for (int place = 0; place < PROFILE; place++)
                        gray[place] = look(frame, plus(first, place / (PROFILE - 1.0f), across));
                    float off = crossing(gray, &contrast, &slope), sign = here ? -1 : 1;
                    if (sign * contrast < MIN_CONTRAST)
                        continue;
                    expected(wanted, cells, row, column, down, parts, beside, gray);
                    off -= crossing(gray, &should_contrast, &should_slope);
                    off /= PROFILE - 1;
                    if (!(fabsf(off) <= MAX_OFF))  /* nor what is no number */
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
                    moves[8] = sign;  /* where light outshines dark, it does so at all edges */
                    for (int i = 0; i < UNKNOWNS; i++) {
                        for (int j = 0; j <= i; j++)
                            matrix[i][j] += moves[i] * moves[j];
                        vector[i] += moves[i] * off * size;
                    }
                }
            /* The steeper profiles are beside those expected, the less is blurred. */
            float seen = slopes[0] / larger(contrasts[0], 1e-6f);
            float should = slopes[1] / larger(contrasts[1], 1e-6f);
            float estimate = blur[down] * should / larger(seen, MIN_SLOPE);
            next_blur[down] = larger(MIN_BLUR, smaller(estimate, MAX_BLUR));
        }
        float most = step < STEPS - 1 ? MAX_UNEVEN : MAX_LEFT;
        if (found < MIN_SEEN * edges || found < MIN_EDGES || sum_off > most * found)
            return 0;
        memcpy(blur, next_blur, sizeof blur);
        for (int i = 0; i < UNKNOWNS; i++)
            matrix[i][i] += RIDGE;
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
