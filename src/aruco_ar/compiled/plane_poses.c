/* Refining the two poses of a flat object by the method of Levenberg and Marquardt. */
#include <stdlib.h>

#include "algebra.h"
#include "unit5.h"

#define MAX_STEPS 12              /* number of steps, at most */
#define FIRST_DAMPING 1e-3
#define AFTER_SUCCESS 0.1         /* factor of the damping after a step that lowered the cost */
#define AFTER_FAILURE 8.0         /* factor of the damping after one that did not */
#define WORTHWHILE 1e-3           /* a step that promises less gain, relative to 1 + cost, is not made */
#define FAR_WORSE 100.0           /* a pose with this many times the cost of the other one is not refined further */
#define BEHIND 1e9                /* what a point behind the camera adds to the cost */
#define MIN_EIGENVALUE 1e-12      /* added to a scaled information matrix: above rounding errors, below all else */

const double unit5_nearest = 1e-3;
/* No pose is reported as less certain than this: standard deviations, meters and radians. */
static const double most_uncertain[6] = {1e2, 1e2, 1e2, 1, 1, 1};

/* An object: its points and the rays to them, and how the points deviate together. */
typedef struct {
    int points, deviations;
    const double *point, *ray, *weight, *spread;  /* 3, 2, 2 x 2 and 3 x deviations numbers for each point */
    double *spare;  /* memory for size * size + 2 * size numbers, with size = 6 + deviations */
} Object;

/* A pose, and what linearize finds out about it. */
typedef struct {
    double rotation[9], translation[3], cost;
    double *amounts, *squares, *gradient, *hessian;
} State;

/* Set the cost, the squared errors of the points, the negative half gradient of the cost and the approximate half
   Hessian matrix for the pose and the amounts of a state. */
static void linearize(const Object *object, State *state)
{
    int extra = object->deviations, size = 6 + extra;
    memset(state->gradient, 0, size * sizeof(double));
    memset(state->hessian, 0, size * size * sizeof(double));
    state->cost = dot(state->amounts, state->amounts, extra);
    for (int number = 0; number < object->points; number++) {
        const double *ray = object->ray + 2 * number, *weight = object->weight + 4 * number;
        const double *spread = object->spread + 3 * extra * number, *rotation = state->rotation;
        double point[3], arm[3], errors[2];
        for (int axis = 0; axis < 3; axis++)
            point[axis] = object->point[3 * number + axis] + dot(spread + extra * axis, state->amounts, extra);
        for (int axis = 0; axis < 3; axis++)
            arm[axis] = dot(rotation + 3 * axis, point, 3);
        double distance = arm[2] + state->translation[2], depth = distance > unit5_nearest ? distance : unit5_nearest;
        double x = (arm[0] + state->translation[0]) / depth, y = (arm[1] + state->translation[1]) / depth;
        for (int row = 0; row < 2; row++) {
            const double *w = weight + 2 * row;
            /* First by the point's coordinates, which are those of the translation. */
            double *by = object->spare + size * row;
            errors[row] = w[0] * (ray[0] - x) + w[1] * (ray[1] - y);
            by[0] = w[0] / depth;
            by[1] = w[1] / depth;
            by[2] = -(w[0] * x + w[1] * y) / depth;
            cross3(arm, by, by + 3);
            for (int each = 0; each < extra; each++) {
                by[6 + each] = 0;
                for (int axis = 0; axis < 3; axis++)
                    by[6 + each] += (by[0] * rotation[axis] + by[1] * rotation[3 + axis] + by[2] * rotation[6 + axis])
                                    * spread[extra * axis + each];
            }
            for (int one = 0; one < size; one++) {
                state->gradient[one] += by[one] * errors[row];
                for (int other = 0; other <= one; other++)
                    state->hessian[size * one + other] += by[one] * by[other];
            }
        }
        state->squares[number] = dot(errors, errors, 2);
        state->cost += state->squares[number] + (distance < unit5_nearest ? BEHIND : 0);
    }
    for (int each = 6; each < size; each++) {  /* the amounts have a standard deviation of 1 */
        state->hessian[(size + 1) * each] += 1;
        state->gradient[each] -= state->amounts[each - 6];
    }
}

/* Find the next step of a state. Returns whether it is worth making. ``least``: the cost of the better pose. ``spare``:
   see Object. */
static int find_step(const State *state, double damping, double least, int size, double *step, double *spare)
{
    double *matrix = spare;
    memcpy(matrix, state->hessian, size * size * sizeof(double));
    for (int each = 0; each < size; each++)
        matrix[(size + 1) * each] *= 1 + damping;
    memcpy(step, state->gradient, size * sizeof(double));
    if (!factorize(matrix, size))
        return 0;
    solve(matrix, size, step);
    return dot(step, state->gradient, size) >= WORTHWHILE * (1 + state->cost)
        && state->cost <= FAR_WORSE * (1 + least);
}

/* The inverse of the information matrix of a state, kept positive definite.

   Its entries differ greatly in size. What is hardly determined by them may be lost in rounding errors, so that an
   entry seems to be 0 or negative. */
static void invert(const State *state, int size, double *covariance, double *spare)
{
    double *matrix = spare, *scale = matrix + size * size, *column = scale + size;
    memcpy(matrix, state->hessian, size * size * sizeof(double));
    for (int each = 0; each < 6; each++)
        matrix[(size + 1) * each] += 1 / (most_uncertain[each] * most_uncertain[each]);
    for (int each = 0; each < size; each++)
        scale[each] = sqrt(matrix[(size + 1) * each]);
    for (int one = 0; one < size; one++)
        for (int other = 0; other <= one; other++)
            matrix[size * one + other] = matrix[size * one + other] / (scale[one] * scale[other])
                                         + (one == other ? MIN_EIGENVALUE : 0);
    int is_good = factorize(matrix, size);
    for (int one = 0; one < size; one++) {
        memset(column, 0, size * sizeof(double));
        column[one] = is_good ? 1 : NAN;
        solve(matrix, size, column);
        for (int other = 0; other < size; other++)
            covariance[size * one + other] = column[other] / (scale[one] * scale[other]);
    }
}

/* Refine the two poses of an object.

   ``memory``: for 2 * size + 4 * (deviations + points + size + size * size) numbers, with size = 6 + deviations. For
   the others, see unit5_refine_pose_pairs. */
static void refine_pair(const Object *object, double *rotations, double *translations, double *amounts,
                        double *squares, double *covariances, double *memory)
{
    int extra = object->deviations, size = 6 + extra, points = object->points;
    double damping[2] = {FIRST_DAMPING, FIRST_DAMPING}, *step[2] = {memory, memory + size};
    State states[4];  /* where the two poses are, and where they go next */
    for (int which = 0; which < 4; which++) {
        State *state = states + which;
        state->amounts = memory + 2 * size + which * (extra + points + size + size * size);
        state->squares = state->amounts + extra;
        state->gradient = state->squares + points;
        state->hessian = state->gradient + size;
    }
    State *here[2] = {states, states + 1}, *next[2] = {states + 2, states + 3};
    for (int which = 0; which < 2; which++) {
        memcpy(here[which]->rotation, rotations + 9 * which, sizeof here[which]->rotation);
        memcpy(here[which]->translation, translations + 3 * which, sizeof here[which]->translation);
        memcpy(here[which]->amounts, amounts + extra * which, extra * sizeof(double));
        linearize(object, here[which]);
    }
    for (int round = 0; round < MAX_STEPS; round++) {
        double least = fmin(here[0]->cost, here[1]->cost);
        int is_moving[2];
        for (int which = 0; which < 2; which++)
            is_moving[which] = find_step(here[which], damping[which], least, size, step[which], object->spare);
        if (!is_moving[0] && !is_moving[1])
            break;
        for (int which = 0; which < 2; which++) {
            if (!is_moving[which])
                continue;
            State *from = here[which], *to = next[which];
            turn_rotation(step[which] + 3, from->rotation, to->rotation);
            for (int axis = 0; axis < 3; axis++)
                to->translation[axis] = from->translation[axis] + step[which][axis];
            for (int each = 0; each < extra; each++)
                to->amounts[each] = from->amounts[each] + step[which][6 + each];
            linearize(object, to);
            int is_better = to->cost < from->cost;
            damping[which] *= is_better ? AFTER_SUCCESS : AFTER_FAILURE;
            if (is_better) {
                here[which] = to;
                next[which] = from;
            }
        }
    }
    for (int which = 0; which < 2; which++) {
        memcpy(rotations + 9 * which, here[which]->rotation, sizeof here[which]->rotation);
        memcpy(translations + 3 * which, here[which]->translation, sizeof here[which]->translation);
        memcpy(amounts + extra * which, here[which]->amounts, extra * sizeof(double));
        memcpy(squares + points * which, here[which]->squares, points * sizeof(double));
        invert(here[which], size, covariances + size * size * which, object->spare);
    }
}

int unit5_refine_pose_pairs(int64_t objects, int points, int deviations, const double *point, const double *ray,
                            const double *weight, const double *spread, double *rotations, double *translations,
                            double *amounts, double *squares, double *covariances)
{
    int64_t size = 6 + deviations, spare = size * size + 2 * size;
    double *memory = malloc((spare + 2 * size + 4 * (deviations + points + size + size * size)) * sizeof(double));
    if (!memory)
        return 0;
    for (int64_t number = 0; number < objects; number++) {
        Object object = {points, deviations, point + 3 * points * number, ray + 2 * points * number,
                         weight + 4 * points * number, spread, memory};
        refine_pair(&object, rotations + 18 * number, translations + 6 * number, amounts + 2 * deviations * number,
                    squares + 2 * points * number, covariances + 2 * size * size * number, memory + spare);
    }
    free(memory);
    return 1;
}
