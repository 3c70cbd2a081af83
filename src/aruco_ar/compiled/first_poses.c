/* The two poses of a flat object, from the homography of its plane (T. Collins and A. Bartoli, Infinitesimal
   Plane-Based Pose Estimation, 2014). */
#include "algebra.h"
#include "unit5.h"

#define UNKNOWNS 8  /* of a homography, whose last entry is 1 */

/* Positions of an object's points, or of its rays, with their mean at 0 and a mean square of 1. */
typedef struct {
    double mean[2], size;
} Frame;

/* ``values``: those of the first point; ``stride``: how many numbers farther those of the next one are. */
static Frame frame_of(const double *values, int stride, int count)
{
    Frame frame = {{0, 0}, 0};
    for (int number = 0; number < count; number++)
        for (int axis = 0; axis < 2; axis++)
            frame.mean[axis] += values[stride * number + axis] / count;
    for (int number = 0; number < count; number++)
        for (int axis = 0; axis < 2; axis++) {
            double off = values[stride * number + axis] - frame.mean[axis];
            frame.size += off * off / count;
        }
    frame.size = sqrt(frame.size);
    return frame;
}

/* Write the homography from the plane to the rays, both in their frames. Its last entry is 1, as the middle of the
   points is in front of the camera. Returns whether there is one. */
static int homography_of(int count, const double *point, const double *ray, const Frame *plane, const Frame *seen,
                         double to[UNKNOWNS])
{
    double matrix[UNKNOWNS * UNKNOWNS] = {0};
    memset(to, 0, UNKNOWNS * sizeof(double));
    for (int number = 0; number < count; number++) {
        double x = (point[3 * number] - plane->mean[0]) / plane->size;
        double y = (point[3 * number + 1] - plane->mean[1]) / plane->size;
        for (int axis = 0; axis < 2; axis++) {
            double value = (ray[2 * number + axis] - seen->mean[axis]) / seen->size;
            double row[UNKNOWNS] = {0};
            row[3 * axis] = x;
            row[3 * axis + 1] = y;
            row[3 * axis + 2] = 1;
            row[6] = -value * x;
            row[7] = -value * y;
            for (int one = 0; one < UNKNOWNS; one++) {
                to[one] += row[one] * value;
                for (int other = 0; other <= one; other++)
                    matrix[UNKNOWNS * one + other] += row[one] * row[other];
            }
        }
    }
    if (!factorize(matrix, UNKNOWNS))
        return 0;
    solve(matrix, UNKNOWNS, to);
    return 1;
}

/* Write the two rotations for the derivative of the rays by the plane's coordinates at a point that is seen along
   the ray (p, q). Returns whether there are any. */
static int rotations_of(double slope[2][2], const double ray[2], double rotations[2][9])
{
    /* The rotation that turns the z axis to the ray. */
    double length = sqrt(ray[0] * ray[0] + ray[1] * ray[1] + 1);
    double x = ray[0] / length, y = ray[1] / length, z = 1 / length, bend = 1 / (1 + z);
    double toward[3][3] = {{1 - bend * x * x, -bend * x * y, x}, {-bend * x * y, 1 - bend * y * y, y}, {-x, -y, z}};
    double b[2][2], part[2][2];
    for (int row = 0; row < 2; row++)
        for (int column = 0; column < 2; column++)
            b[row][column] = toward[row][column] - ray[row] * toward[2][column];
    double determinant = b[0][0] * b[1][1] - b[0][1] * b[1][0];
    for (int column = 0; column < 2; column++) {
        part[0][column] = (b[1][1] * slope[0][column] - b[0][1] * slope[1][column]) / determinant;
        part[1][column] = (b[0][0] * slope[1][column] - b[1][0] * slope[0][column]) / determinant;
    }
    /* Along the direction in which the plane is not inclined, nothing is foreshortened: there, the derivative is the
       largest, and the inverse of the distance. */
    double xx = part[0][0] * part[0][0] + part[0][1] * part[0][1];
    double yy = part[1][0] * part[1][0] + part[1][1] * part[1][1];
    double xy = part[0][0] * part[1][0] + part[0][1] * part[1][1];
    double nearness = sqrt((xx + yy + sqrt((xx - yy) * (xx - yy) + 4 * xy * xy)) / 2);
    if (!(nearness > 0 && isfinite(nearness)))
        return 0;
    /* The columns of the rotation have a length of 1, and are perpendicular. */
    double column[2][3], third[3];
    for (int number = 0; number < 2; number++) {
        column[number][0] = part[0][number] / nearness;
        column[number][1] = part[1][number] / nearness;
        column[number][2] = sqrt(fmax(0, 1 - dot(column[number], column[number], 2)));
    }
    if (dot(column[0], column[1], 2) > 0)
        column[1][2] = -column[1][2];
    for (int which = 0; which < 2; which++) {
        cross3(column[0], column[1], third);
        for (int row = 0; row < 3; row++) {
            rotations[which][3 * row] = dot(toward[row], column[0], 3);
            rotations[which][3 * row + 1] = dot(toward[row], column[1], 3);
            rotations[which][3 * row + 2] = dot(toward[row], third, 3);
        }
        column[0][2] = -column[0][2];
        column[1][2] = -column[1][2];
    }
    return 1;
}

/* Write the translation with which points, turned by a rotation, are seen best along rays. Returns whether there is
   one in front of the camera. */
static int translation_of(int count, const double *point, const double *ray, const double rotation[9],
                          double translation[3])
{
    double matrix[9] = {0};
    memset(translation, 0, 3 * sizeof(double));
    for (int number = 0; number < count; number++) {
        double arm[3];
        for (int axis = 0; axis < 3; axis++)
            arm[axis] = dot(rotation + 3 * axis, point + 3 * number, 3);
        for (int axis = 0; axis < 2; axis++) {
            double value = ray[2 * number + axis], off = value * arm[2] - arm[axis];
            matrix[4 * axis] += 1;
            matrix[6 + axis] -= value;
            matrix[8] += value * value;
            translation[axis] += off;
            translation[2] -= value * off;
        }
    }
    if (!factorize(matrix, 3))
        return 0;
    solve(matrix, 3, translation);
    return translation[2] > unit5_nearest && isfinite(dot(translation, translation, 3));
}

/* Find the two poses of an object. Returns whether there are any. If there is only one, both are that. */
static int find_pair(int count, const double *point, const double *ray, double *rotations, double *translations)
{
    Frame plane = frame_of(point, 3, count), seen = frame_of(ray, 2, count);
    double to[UNKNOWNS], slope[2][2], middle[2], found[2][9];
    if (!homography_of(count, point, ray, &plane, &seen, to))
        return 0;
    for (int axis = 0; axis < 2; axis++) {
        middle[axis] = seen.mean[axis] + seen.size * to[3 * axis + 2];
        for (int by = 0; by < 2; by++)
            slope[axis][by] = (to[3 * axis + by] - to[3 * axis + 2] * to[6 + by]) * seen.size / plane.size;
    }
    if (!rotations_of(slope, middle, found))
        return 0;
    int good[2];
    for (int which = 0; which < 2; which++) {
        memcpy(rotations + 9 * which, found[which], sizeof found[which]);
        good[which] = translation_of(count, point, ray, found[which], translations + 3 * which);
    }
    for (int which = 0; which < 2; which++)
        if (!good[which] && good[1 - which]) {
            memcpy(rotations + 9 * which, found[1 - which], sizeof found[0]);
            memcpy(translations + 3 * which, translations + 3 * (1 - which), 3 * sizeof(double));
        }
    return good[0] || good[1];
}

void unit5_find_pose_pairs(int64_t objects, int points, const double *point, const double *ray, double *rotations,
                           double *translations, uint8_t *posed)
{
    for (int64_t number = 0; number < objects; number++)
        posed[number] = find_pair(points, point + 3 * points * number, ray + 2 * points * number,
                                  rotations + 18 * number, translations + 6 * number);
}
