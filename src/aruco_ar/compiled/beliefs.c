/* Which of the two poses of an object is believed. belief.py says why that works. */
#include "algebra.h"
#include "unit5.h"

#define SPEED 1.0             /* m/s: the standard deviation of the camera's speed relative to the object */
#define UNSTEADY 1e-3         /* s: the camera moves as if at least this time had passed */
/* The errors of corners repeat from frame to frame. So evidence decays with this time constant, in seconds, and counts
   only this part of what it would count if the errors were independent. */
#define MEMORY 0.5
#define EVIDENCE 0.5
#define LEAP 1e-4             /* the probability that the camera has moved in any other way */
#define SWITCH 0.9            /* the other pose must be at least this probable to become the believed one */
#define GAP 0.5               /* s: if an object was out of sight for longer, its earlier evidence is not used */
#define SAME 0.1              /* two poses are the same if they differ by less than this share of a pose's variance */
#define MIN_LOG_WEIGHT -60.0  /* the natural logarithm of the smallest weight */

/* What is remembered of an object: when it was seen; the logarithms of the weights of its poses; where the camera was in
   the object's own axes by each of them, meters, and the covariance of that; and which pose was believed. */
typedef struct {
    double time, weight[2], place[2][3], spread[2][9], believed;
} Memory;

const int unit5_belief_size = sizeof(Memory) / sizeof(double);

/* The logarithm of the sum of two numbers with these logarithms. */
static double log_sum(double one, double other)
{
    double more = fmax(one, other);
    return more + log1p(exp(fmin(one, other) - more));
}

/* The logarithm of how likely the camera moves from a place to another one, but for a constant summand. */
static double log_likelihood(const Memory *before, int from, const Memory *now, int to, double passed)
{
    double covariance[9], moved[3], scaled[3], logarithm = 0;
    for (int at = 0; at < 9; at++)
        covariance[at] = before->spread[from][at] + now->spread[to][at];
    for (int axis = 0; axis < 3; axis++) {
        covariance[4 * axis] += SPEED * SPEED * (passed * passed + UNSTEADY * UNSTEADY);
        moved[axis] = scaled[axis] = now->place[to][axis] - before->place[from][axis];
    }
    if (!factorize(covariance, 3))
        return MIN_LOG_WEIGHT;
    solve(covariance, 3, scaled);
    for (int axis = 0; axis < 3; axis++)
        logarithm += 2 * log(covariance[4 * axis]);
    return -(dot(moved, scaled, 3) + logarithm) / 2;
}

/* Add the earlier evidence to the weights of this frame. Returns which pose continues the believed one. */
static int add_history(const Memory *before, Memory *now)
{
    double passed = now->time - before->time, likelihood[2][2], most = -INFINITY;
    for (int from = 0; from < 2; from++)
        for (int to = 0; to < 2; to++) {
            likelihood[from][to] = log_likelihood(before, from, now, to, passed);
            most = fmax(most, likelihood[from][to]);
        }
    for (int from = 0; from < 2; from++)
        for (int to = 0; to < 2; to++)
            likelihood[from][to] = log_sum(likelihood[from][to] - most, log(LEAP));
    double fade = exp(-passed / MEMORY);
    for (int to = 0; to < 2; to++)
        now->weight[to] += log_sum(fade * before->weight[0] + likelihood[0][to],
                                   fade * before->weight[1] + likelihood[1][to]);
    const double *next = likelihood[before->believed > 0];
    return next[1] > next[0];
}

/* Write where the camera is in the axes of an object with a pose, and the covariance of that. */
static void place_camera(const double rotation[9], const double translation[3], const double covariance[36],
                         double place[3], double spread[9])
{
    double jacobian[18], spare[6];
    turn_back(rotation, translation, place);
    for (int axis = 0; axis < 3; axis++) {
        double back[3] = {rotation[axis], rotation[3 + axis], rotation[6 + axis]};
        place[axis] = -place[axis];
        memcpy(jacobian + 6 * axis, back, sizeof back);
        cross3(back, translation, jacobian + 6 * axis + 3);
    }
    carry_covariance(jacobian, 3, covariance, 6, spread, spare);
}

void unit5_weigh_poses(int64_t count, const double *rotations, const double *translations, const double *covariances,
                       const double *costs, double now, double *memories, int64_t *believed, double *weights)
{
    for (int64_t number = 0; number < count; number++) {
        Memory *memory = (Memory *)memories + number, seen = {.time = now};
        const double *cost = costs + 2 * number;
        for (int which = 0; which < 2; which++) {
            int64_t at = 2 * number + which;
            place_camera(rotations + 9 * at, translations + 3 * at, covariances + 36 * at, seen.place[which],
                         seen.spread[which]);
            seen.weight[which] = fmax(EVIDENCE / 2 * (fmin(cost[0], cost[1]) - cost[which]), MIN_LOG_WEIGHT);
        }
        int first = seen.weight[1] > seen.weight[0];
        if (now - memory->time >= 0 && now - memory->time <= GAP)
            first = add_history(memory, &seen);
        double sum = log_sum(seen.weight[0], seen.weight[1]);
        seen.weight[0] -= sum;
        seen.weight[1] -= sum;
        if (seen.weight[1 - first] > log(SWITCH))
            first = 1 - first;
        seen.believed = first;
        *memory = seen;
        believed[number] = first;
        weights[number] = fmin(exp(seen.weight[1 - first]), 0.5);
    }
}

void unit5_mix_poses(int64_t count, const double *rotations, const double *translations, const double *covariances,
                     const double *other_rotations, const double *other_translations, const double *other_covariances,
                     double *weights, double *mixed)
{
    for (int64_t number = 0; number < count; number++) {
        const double *rotation = rotations + 9 * number, *other = other_rotations + 9 * number;
        const double *covariance = covariances + 36 * number, *other_covariance = other_covariances + 36 * number;
        double between[9], leap[6], share = weights[number];
        for (int row = 0; row < 3; row++)
            for (int column = 0; column < 3; column++)
                between[3 * row + column] = dot(other + 3 * row, rotation + 3 * column, 3);
        for (int axis = 0; axis < 3; axis++)
            leap[axis] = other_translations[3 * number + axis] - translations[3 * number + axis];
        rotation_angles(between, leap + 3);
        if (dot(leap + 3, leap + 3, 3) < SAME * (covariance[21] + covariance[28] + covariance[35]))
            share = weights[number] = 0;
        for (int one = 0; one < 6; one++)
            for (int each = 0; each < 6; each++) {
                int at = 6 * one + each;
                mixed[36 * number + at] = (1 - share) * covariance[at]
                                          + share * (other_covariance[at] + leap[one] * leap[each]);
            }
    }
}
