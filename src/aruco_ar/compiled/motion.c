/* The Kalman filter of an area's four corners and their speeds; motion.py says what it is for.

   It is in C since its many small matrices take much longer in NumPy than it takes to find the tags. */
#include "algebra.h"
#include "unit5.h"

/* How much the speeds change within a second, as standard deviations. The model is a rigid camera that faces a plane,
   moved by a robot or a hand. */
#define TURN_CHANGE 0.1      /* rad/s: pan, tilt, roll */
#define SHIFT_CHANGE 0.05    /* distances to the wall per second: sideways, up, forward */
#define SPEED_FACTOR 1.0     /* this times the current speed is added to both, since fast motion also changes fast */
/* Since slant and lens are unknown, the corners also move a little in other ways. */
#define OTHER_CHANGE 0.005   /* widths of the frame per second */
#define FIRST_SPEED 1.5      /* assumed speed of an area just found, in rad/s and distances to the wall per second */
#define FOCAL 0.87           /* assumed focal length, in widths of the frame */
#define CURVE 0.3            /* the corners accelerate by this times speed squared / radius, as on a curve */
#define CALM_S 1.0           /* without a tag in sight, the assumed speed decays with this time constant */
#define JERK_TURN 0.05       /* a sudden turn of the camera, rad */
#define JERK_SHIFT 0.03      /* a sudden shift, distances to the wall */
#define CONVERGED_PX 0.5     /* after a correction by more than this, the measurement is linearized again */
#define MAX_ITERATIONS 3     /* number of such linearizations in a correction, at most */

#define MOVES 6              /* of a camera: pan, tilt, roll; sideways, up, forward */

typedef double Square[8][8];
/* What a measurement, compared with the prediction, tells about the corners. This is the information form of the
   filter: it inverts a matrix of 8 x 8, not one as large as the measurement. ``information``: how well the measurement
   alone determines the corners. ``shrink``: inverse of 1 + information * covariance. ``toward``: the correction of the
   corners, which is still to be multiplied by the covariance. ``effect``: of the biases that all tags have in common,
   on the gradient. */
typedef struct { Square information, shrink, effect; double toward[8], unlikeliness; } Comparison;

/* Each camera's moves in terms of the eight infinitesimal homographies; see moves_of. */
static const double camera_moves[8][MOVES] = {
    {1, 0, 0, 1, 0, 0}, {0, 1, 0, 0, 1, 0}, {0, 0, 0, 0, 0, 1}, {0, 0, 1, 0, 0, 0},
    {0, 0, -1, 0, 0, 0}, {0, 0, 0, 0, 0, 1}, {1, 0, 0, 0, 0, 0}, {0, 1, 0, 0, 0, 0}};

static void multiply(const Square a, const Square b, Square product)
{
    for (int i = 0; i < 8; i++) {
        double row[8] = {0};
        for (int k = 0; k < 8; k++)
            for (int j = 0; j < 8; j++)
                row[j] += a[i][k] * b[k][j];
        memcpy(product[i], row, sizeof row);
    }
}

/* Invert a matrix in place, by Gauss and Jordan. What cannot be inverted becomes very large. */
static void invert(Square matrix)
{
    int swapped[8];
    for (int i = 0; i < 8; i++) {
        int best = i;
        for (int row = i + 1; row < 8; row++)
            if (fabs(matrix[row][i]) > fabs(matrix[best][i]))
                best = row;
        swapped[i] = best;
        for (int j = 0; j < 8 && best != i; j++) {
            double other = matrix[i][j];
            matrix[i][j] = matrix[best][j];
            matrix[best][j] = other;
        }
        double scale = 1 / (matrix[i][i] != 0 ? matrix[i][i] : 1e-30);
        matrix[i][i] = 1;
        for (int j = 0; j < 8; j++)
            matrix[i][j] *= scale;
        for (int row = 0; row < 8; row++) {
            double factor = matrix[row][i];
            if (row == i)
                continue;
            matrix[row][i] = 0;
            for (int j = 0; j < 8; j++)
                matrix[row][j] -= factor * matrix[i][j];
        }
    }
    for (int i = 7; i >= 0; i--)
        for (int row = 0; row < 8 && swapped[i] != i; row++) {
            double other = matrix[row][i];
            matrix[row][i] = matrix[row][swapped[i]];
            matrix[row][swapped[i]] = other;
        }
}

/* How a pixel moves under each of the eight infinitesimal homographies: two shifts, four linear ones, and two that
   change the perspective. */
static void moves_of(const Motion *motion, double x, double y, double across[8], double down[8])
{
    double f = motion->focal, u = (x - motion->middle[0]) / f, v = (y - motion->middle[1]) / f;
    const double one[8] = {f, 0, f * u, 0, f * v, 0, f * u * u, f * u * v};
    const double other[8] = {0, f, 0, f * u, 0, f * v, f * u * v, f * v * v};
    memcpy(across, one, sizeof one);
    memcpy(down, other, sizeof other);
}

static void moves_of_corners(const Motion *motion, Square moves)
{
    for (int corner = 0; corner < 4; corner++)
        moves_of(motion, motion->place[2 * corner], motion->place[2 * corner + 1], moves[2 * corner],
                 moves[2 * corner + 1]);
}

/* Add what a camera does to the corners that moves with these standard deviations: turns, and shifts. */
static void add_camera(const Motion *motion, double turn, double shift, Square covariance)
{
    Square moves;
    double moved[8][MOVES] = {{0}};
    moves_of_corners(motion, moves);
    for (int i = 0; i < 8; i++)
        for (int move = 0; move < MOVES; move++) {
            for (int k = 0; k < 8; k++)
                moved[i][move] += moves[i][k] * camera_moves[k][move];
            moved[i][move] *= move < 3 ? turn : shift;
        }
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++)
            for (int move = 0; move < MOVES; move++)
                covariance[i][j] += moved[i][move] * moved[j][move];
}

/* The covariance of the change of the corners' speeds within a second. ``speed``: rad/s and distances to the wall per
   second, the least speed that the camera may have. */
static void speed_change(const Motion *motion, double speed, Square change)
{
    double square = 0, other = OTHER_CHANGE * motion->focal / FOCAL;
    for (int i = 0; i < 8; i++)
        square += motion->speed[i] * motion->speed[i];
    speed = fmax(speed, SPEED_FACTOR * sqrt(square / 4) / motion->focal);
    memset(change, 0, sizeof(Square));
    add_camera(motion, TURN_CHANGE + speed, SHIFT_CHANGE + speed, change);
    for (int i = 0; i < 8; i++)
        change[i][i] += other * other;
}

/* Pixels per second squared: the standard deviation of the corners' acceleration, from frame to frame. The prediction is
   a straight line, but a corner moves on a curve if the camera rolls or goes round. This hardly matters at 30 frames a
   second, but much at 4. */
static double acceleration(const Motion *motion)
{
    double middle[2] = {0}, speed = 0, radius = 0;
    for (int i = 0; i < 8; i++)
        middle[i % 2] += motion->place[i] / 4;
    for (int i = 0; i < 8; i += 2) {
        double x = motion->place[i] - middle[0], y = motion->place[i + 1] - middle[1];
        speed = fmax(speed, motion->speed[i] * motion->speed[i] + motion->speed[i + 1] * motion->speed[i + 1]);
        radius = fmax(radius, x * x + y * y);
    }
    return CURVE * speed / fmax(sqrt(radius), 1);
}

/* Sum up a measurement, linearized at the corners. ``pixels``: NULL, or where the points are seen. Then also the
   ``gradient``, and the squares of what they are off, divided by their variances. ``before``: the predicted corners.
   ``bias``: NULL, or of each point. */
static void sum_up(const Motion *motion, int64_t count, const double *points, const double *pixels,
                   const double *deviation, const double *bias, const double *before, Comparison *compared,
                   double gradient[8], double *squares)
{
    double to[9];
    Square inverse;
    memset(compared, 0, sizeof *compared);
    memset(gradient, 0, 8 * sizeof *gradient);
    *squares = 0;
    square_to(motion->place, to);
    moves_of_corners(motion, inverse);
    invert(inverse);
    for (int64_t point = 0; point < count; point++) {
        double seen[2], moves[2][8], weight = 1 / (deviation[point] * deviation[point]);
        map_point(to, points[2 * point], points[2 * point + 1], seen);
        moves_of(motion, seen[0], seen[1], moves[0], moves[1]);
        for (int axis = 0; axis < 2; axis++) {
            double slope[8] = {0}, off = pixels ? pixels[2 * point + axis] - seen[axis] : 0;
            for (int k = 0; k < 8; k++)
                for (int j = 0; j < 8; j++)
                    slope[j] += moves[axis][k] * inverse[k][j];
            for (int k = 0; k < 8 && pixels; k++)
                off += slope[k] * (motion->place[k] - before[k]);
            for (int i = 0; i < 8; i++) {
                double weighted = weight * slope[i];
                for (int j = 0; j < 8; j++)
                    compared->information[i][j] += weighted * slope[j];
                gradient[i] += weighted * off;
                if (bias)
                    compared->effect[i][(2 * point + axis) % 8] += weighted * bias[point];
            }
            *squares += weight * off * off;
        }
    }
}

/* Compare a measurement with the prediction: the corners ``before``, and their covariance. */
static void compare(const Motion *motion, int64_t count, const double *points, const double *pixels,
                    const double *deviation, const double *bias, const double *before, const Square covariance,
                    Comparison *compared)
{
    double gradient[8], squares, explained = 0;
    sum_up(motion, count, points, pixels, deviation, bias, before, compared, gradient, &squares);
    multiply(compared->information, covariance, compared->shrink);
    for (int i = 0; i < 8; i++)
        compared->shrink[i][i] += 1;
    invert(compared->shrink);
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++)
            compared->toward[i] += compared->shrink[i][j] * gradient[j];
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++)
            explained += gradient[i] * covariance[i][j] * compared->toward[j];
    compared->unlikeliness = (squares - explained) / (2 * count);
}

/* The covariance of the corners alone; ``biased``: including the biases. */
static void covariance_of_corners(const Motion *motion, int biased, Square covariance)
{
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++) {
            covariance[i][j] = motion->covariance[i][j];
            for (int k = 0; k < 8 && biased; k++)
                covariance[i][j] += motion->biased[i][k] * motion->biased[j][k];
        }
}

void unit5_start_motion(Motion *motion, int64_t count, const double *points, const double *deviation,
                        const double *bias)
{
    Comparison compared;
    Square covariance, change;
    double gradient[8], squares;
    motion->focal = FOCAL * (2 * motion->middle[0] + 1);
    memset(motion->speed, 0, sizeof motion->speed);
    memset(motion->covariance, 0, sizeof motion->covariance);
    sum_up(motion, count, points, NULL, deviation, bias, NULL, &compared, gradient, &squares);
    memcpy(covariance, compared.information, sizeof covariance);
    for (int i = 0; i < 8; i++)
        covariance[i][i] += 1 / (motion->focal * motion->focal);
    invert(covariance);
    multiply(covariance, compared.effect, motion->biased);
    speed_change(motion, FIRST_SPEED, change);
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++) {
            motion->covariance[i][j] = covariance[i][j];
            motion->covariance[8 + i][8 + j] = change[i][j];
        }
}

void unit5_predict_motion(Motion *motion, double seconds, int calm)
{
    for (int i = 0; i < 8; i++) {
        motion->speed[i] *= calm ? exp(-seconds / CALM_S) : 1;
        motion->place[i] += seconds * motion->speed[i];
    }
    Square change;
    double turn = acceleration(motion) * seconds, (*p)[16] = motion->covariance;
    speed_change(motion, 0, change);
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++) {
            double changed = change[i][j] * seconds, turned = i == j ? turn * turn : 0;
            p[i][j] += seconds * (p[8 + i][j] + p[8 + j][i])
                + seconds * seconds * (p[8 + i][8 + j] + changed / 3 + turned / 4);
        }
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++) {
            double changed = change[i][j] * seconds, turned = i == j ? turn * turn : 0;
            p[8 + i][j] += seconds * (p[8 + i][8 + j] + changed / 2 + turned / 2);
            p[j][8 + i] = p[8 + i][j];
            p[8 + i][8 + j] += changed + turned;
        }
}

void unit5_jerk_motion(Motion *motion)
{
    Square corners = {{0}}, change;
    add_camera(motion, JERK_TURN, JERK_SHIFT, corners);
    speed_change(motion, FIRST_SPEED, change);
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++) {
            motion->covariance[i][j] += corners[i][j];
            motion->covariance[8 + i][8 + j] += change[i][j];
        }
}

void unit5_project(const Motion *motion, int64_t count, const double *points, double *pixels)
{
    double to[9];
    square_to(motion->place, to);
    for (int64_t point = 0; point < count; point++)
        map_point(to, points[2 * point], points[2 * point + 1], pixels + 2 * point);
}

void unit5_find_deviation(const Motion *motion, double deviation[4])
{
    for (int corner = 0; corner < 4; corner++) {
        double variance = 0;
        for (int i = 2 * corner; i < 2 * corner + 2; i++) {
            variance += motion->covariance[i][i];
            for (int k = 0; k < 8; k++)
                variance += motion->biased[i][k] * motion->biased[i][k];
        }
        deviation[corner] = sqrt(fmax(variance, 0));
    }
}

double unit5_unlikeliness(const Motion *motion, int64_t count, const double *points, const double *pixels,
                          const double *deviation)
{
    Comparison compared;
    Square covariance;
    covariance_of_corners(motion, 1, covariance);
    compare(motion, count, points, pixels, deviation, NULL, motion->place, covariance, &compared);
    return compared.unlikeliness;
}

int unit5_correct_motion(Motion *motion, int64_t count, const double *points, const double *pixels,
                         const double *deviation, const double *bias, double limit)
{
    Comparison compared;
    Square corners, gain, product, added;
    double before[8], change[16], p[16][16];
    memcpy(before, motion->place, sizeof before);
    memcpy(p, motion->covariance, sizeof p);
    covariance_of_corners(motion, 0, corners);
    compare(motion, count, points, pixels, deviation, bias, before, corners, &compared);
    if (compared.unlikeliness > limit) {  /* a bias in all frames so far may explain the difference */
        covariance_of_corners(motion, 1, corners);
        compare(motion, count, points, pixels, deviation, bias, before, corners, &compared);
        if (compared.unlikeliness > limit)
            return 0;
        for (int i = 0; i < 8; i++)
            memcpy(p[i], corners[i], sizeof corners[i]);
    }
    for (int iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
        double step = 0;
        if (iteration)
            compare(motion, count, points, pixels, deviation, bias, before, corners, &compared);
        for (int i = 0; i < 16; i++) {
            change[i] = 0;
            for (int k = 0; k < 8; k++)
                change[i] += p[i][k] * compared.toward[k];
        }
        for (int i = 0; i < 8; i++) {
            step = fmax(step, fabs(before[i] + change[i] - motion->place[i]));
            motion->place[i] = before[i] + change[i];
        }
        if (step < CONVERGED_PX)
            break;
    }
    for (int i = 0; i < 8; i++)
        motion->speed[i] += change[8 + i];
    /* The biases: what they did so far is corrected as all else is, and those of this measurement are added. */
    multiply(corners, compared.shrink, gain);
    multiply(compared.information, motion->biased, product);
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++)
            product[i][j] = compared.effect[i][j] - product[i][j];
    multiply(gain, product, added);
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < 8; j++)
            motion->biased[i][j] += added[i][j];
    /* What the measurement tells is subtracted from the covariance, which stays symmetric. */
    double told[16][8] = {{0}}, left[16][16];
    multiply(compared.shrink, compared.information, product);
    for (int i = 0; i < 16; i++)
        for (int k = 0; k < 8; k++)
            for (int j = 0; j < 8; j++)
                told[i][j] += p[i][k] * product[k][j];
    for (int i = 0; i < 16; i++)
        for (int j = 0; j < 16; j++) {
            left[i][j] = p[i][j];
            for (int k = 0; k < 8; k++)
                left[i][j] -= told[i][k] * p[k][j];
        }
    for (int i = 0; i < 16; i++)
        for (int j = 0; j < 16; j++)
            motion->covariance[i][j] = (left[i][j] + left[j][i]) / 2;
    return 1;
}
