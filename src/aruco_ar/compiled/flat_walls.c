/* Tags on one wall: their poses by the wall's, and how far they are off the plane of the others. */
#include <stdlib.h>

#include "algebra.h"
#include "unit5.h"

#define MEMORY_FRAMES 15.0  /* about this many of the last frames count */

/* What the last frames say of how far a tag is off: fading sums of information, of information times what was seen,
   and of the frames. */
typedef struct {
    double information[9], weighted[3], frames;
} Memory;

const int unit5_flatness_size = sizeof(Memory) / sizeof(double);

int unit5_place_tags(int64_t count, int deviations, const double *wall_rotations, const double *wall_translations,
                     const double *amounts, const double *wall_covariances, const double *rotations,
                     const double *centers, const double *spread, double *tag_rotations, double *tag_translations,
                     double *covariances)
{
    int64_t size = 6 + deviations;
    double *jacobian = malloc(7 * size * sizeof(double));
    if (!jacobian)
        return 0;
    for (int64_t at = 0; at < 2 * count; at++) {
        int64_t number = at / 2, which = at % 2;
        const double *wall = wall_rotations + 9 * which, *own = spread + 6 * deviations * number;
        double off[6], arm[3], turned[9], center[3];
        for (int row = 0; row < 6; row++)
            off[row] = dot(own + deviations * row, amounts + deviations * which, deviations);
        for (int axis = 0; axis < 3; axis++)
            center[axis] = centers[3 * number + axis] + off[axis];
        turn_vector(wall, center, arm);
        turn_rotation(off + 3, rotations + 9 * number, turned);
        for (int row = 0; row < 3; row++) {
            tag_translations[3 * at + row] = arm[row] + wall_translations[3 * which + row];
            for (int column = 0; column < 3; column++)
                tag_rotations[9 * at + 3 * row + column] = wall[3 * row] * turned[column]
                    + wall[3 * row + 1] * turned[3 + column] + wall[3 * row + 2] * turned[6 + column];
        }
        /* By the wall's pose, whose turns move what is far from its origin, and by the deviations. */
        memset(jacobian, 0, 6 * size * sizeof(double));
        for (int row = 0; row < 6; row++)
            jacobian[(size + 1) * row] = 1;
        for (int axis = 0; axis < 3; axis++) {
            int next = (axis + 1) % 3, last = (axis + 2) % 3;
            jacobian[size * axis + 3 + next] = arm[last];
            jacobian[size * axis + 3 + last] = -arm[next];
        }
        for (int row = 0; row < 6; row++)
            for (int axis = 0; axis < 3; axis++)
                for (int each = 0; each < deviations; each++)
                    jacobian[size * row + 6 + each] += wall[3 * (row % 3) + axis]
                                                       * own[deviations * (row / 3 * 3 + axis) + each];
        carry_covariance(jacobian, 6, wall_covariances + size * size * which, size, covariances + 36 * at,
                         jacobian + 6 * size);
    }
    free(jacobian);
    return 1;
}

/* What is known of one tag's height and normal: see unit5_off_others. ``model``: the derivatives by the plane's. */
typedef struct {
    double seen[3], spread[9], model[9], information[9], vector[3];
} Tilt;

static void look_at(Tilt *tilt, const double rotation[9], const double arm[3], const double covariance[36],
                    const double axes[9], const double bulge[9])
{
    double normal[3] = {rotation[2], rotation[5], rotation[8]}, place[3], direction[3], spare[6], weights[9];
    double jacobian[18] = {axes[2], axes[5], axes[8]};
    turn_back(axes, arm, place);
    turn_back(axes, normal, direction);
    tilt->seen[0] = place[2];
    for (int axis = 0; axis < 2; axis++) {
        double along[3] = {axes[axis], axes[3 + axis], axes[6 + axis]};
        tilt->seen[1 + axis] = direction[axis];
        cross3(normal, along, jacobian + 6 * (1 + axis) + 3);
    }
    carry_covariance(jacobian, 3, covariance, 6, tilt->spread, spare);
    for (int at = 0; at < 9; at++) {
        tilt->spread[at] += bulge[at];
        tilt->model[at] = at % 4 == 0;
    }
    tilt->model[1] = -place[0];
    tilt->model[2] = -place[1];
    invert3(tilt->spread, weights);
    double weighted[9];  /* the transpose of the model times the weights */
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            weighted[3 * row + column] = tilt->model[row] * weights[column] + tilt->model[3 + row] * weights[3 + column]
                                         + tilt->model[6 + row] * weights[6 + column];
    for (int row = 0; row < 3; row++)
        turn_back(tilt->model, weighted + 3 * row, tilt->information + 3 * row);
    turn_vector(weighted, tilt->seen, tilt->vector);
}

int unit5_off_others(int64_t count, const double *rotations, const double *translations, const double *covariances,
                     const double axes[9], const double bulge[9], double *off, double *spread)
{
    double middle[3] = {0}, information[9] = {0}, vector[3] = {0};
    Tilt *tilts = malloc((count > 0 ? count : 1) * sizeof(Tilt));
    if (!tilts)
        return 0;
    for (int64_t number = 0; number < count; number++)
        for (int axis = 0; axis < 3; axis++)
            middle[axis] += translations[3 * number + axis] / count;
    for (int64_t number = 0; number < count; number++) {
        double arm[3];
        for (int axis = 0; axis < 3; axis++)
            arm[axis] = translations[3 * number + axis] - middle[axis];
        look_at(tilts + number, rotations + 9 * number, arm, covariances + 36 * number, axes, bulge);
        for (int at = 0; at < 9; at++)
            information[at] += tilts[number].information[at];
        for (int axis = 0; axis < 3; axis++)
            vector[axis] += tilts[number].vector[axis];
    }
    for (int64_t number = 0; number < count; number++) {
        const Tilt *tilt = tilts + number;
        double rest[9], plane[9], rest_vector[3], tilted[3], expected[3], spare[3];
        for (int at = 0; at < 9; at++)
            rest[at] = information[at] - tilt->information[at];
        for (int axis = 0; axis < 3; axis++)
            rest_vector[axis] = vector[axis] - tilt->vector[axis];
        invert3(rest, plane);
        turn_vector(plane, rest_vector, tilted);
        turn_vector(tilt->model, tilted, expected);
        carry_covariance(tilt->model, 3, plane, 3, spread + 9 * number, spare);
        for (int at = 0; at < 9; at++)
            spread[9 * number + at] += tilt->spread[at];
        for (int axis = 0; axis < 3; axis++)
            off[3 * number + axis] = tilt->seen[axis] - expected[axis];
    }
    free(tilts);
    return 1;
}

void unit5_add_off(int64_t count, const double *off, const double *spread, double *memories, double *squared)
{
    for (int64_t number = 0; number < count; number++) {
        Memory *memory = (Memory *)memories + number;
        double added[9], vector[3], mean[3];
        invert3(spread + 9 * number, added);
        turn_vector(added, off + 3 * number, vector);
        for (int at = 0; at < 9; at++)
            memory->information[at] += added[at] - memory->information[at] / MEMORY_FRAMES;
        for (int axis = 0; axis < 3; axis++)
            memory->weighted[axis] += vector[axis] - memory->weighted[axis] / MEMORY_FRAMES;
        memory->frames += 1 - memory->frames / MEMORY_FRAMES;
        double covariance[9];
        invert3(memory->information, covariance);
        turn_vector(covariance, memory->weighted, mean);
        /* The mean is as uncertain as a single frame: the inverse of its covariance is the mean information. */
        squared[number] = dot(memory->weighted, mean, 3) / memory->frames;
    }
}
