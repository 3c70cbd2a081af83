/* Vectors and small matrices. Matrices are row by row. */
#pragma once

#include <math.h>
#include <string.h>

static inline double dot(const double *one, const double *other, int count)
{
    double sum = 0;
    for (int at = 0; at < count; at++)
        sum += one[at] * other[at];
    return sum;
}

static inline void cross3(const double one[3], const double other[3], double product[3])
{
    product[0] = one[1] * other[2] - one[2] * other[1];
    product[1] = one[2] * other[0] - one[0] * other[2];
    product[2] = one[0] * other[1] - one[1] * other[0];
}

/* Factorize a symmetric matrix into L and its transpose (Cholesky). Only its lower half is read, and L is written
   there. Returns whether it is positive definite. */
static inline int factorize(double *matrix, int size)
{
    for (int row = 0; row < size; row++) {
        double *here = matrix + size * row;
        for (int column = 0; column < row; column++)
            here[column] = (here[column] - dot(here, matrix + size * column, column)) / matrix[(size + 1) * column];
        double square = here[row] - dot(here, here, row);
        if (!(square > 0))
            return 0;
        here[row] = sqrt(square);
    }
    return 1;
}

/* Solve L and its transpose for a vector, in place. */
static inline void solve(const double *factor, int size, double *vector)
{
    for (int row = 0; row < size; row++)
        vector[row] = (vector[row] - dot(factor + size * row, vector, row)) / factor[(size + 1) * row];
    for (int row = size - 1; row >= 0; row--) {
        for (int below = row + 1; below < size; below++)
            vector[row] -= factor[size * below + row] * vector[below];
        vector[row] /= factor[(size + 1) * row];
    }
}

/* The product of a matrix, (3, 3), or its transpose, and a vector. */
static inline void turn_vector(const double matrix[9], const double vector[3], double turned[3])
{
    for (int axis = 0; axis < 3; axis++)
        turned[axis] = dot(matrix + 3 * axis, vector, 3);
}

static inline void turn_back(const double matrix[9], const double vector[3], double turned[3])
{
    for (int axis = 0; axis < 3; axis++)
        turned[axis] = matrix[axis] * vector[0] + matrix[3 + axis] * vector[1] + matrix[6 + axis] * vector[2];
}

/* The homography from the unit square to corners, x and y, row by row: the closed form in P. Heckbert, Fundamentals of
   Texture Mapping and Image Warping, 1989, section 2.2.3. */
static inline void square_to(const double p[8], double to[9])
{
    double one_x = p[2] - p[4], one_y = p[3] - p[5], other_x = p[6] - p[4], other_y = p[7] - p[5];
    double rest_x = p[0] - p[2] + p[4] - p[6], rest_y = p[1] - p[3] + p[5] - p[7];
    double area = one_x * other_y - one_y * other_x;
    area = area != 0 ? area : 1e-9;
    double g = (rest_x * other_y - rest_y * other_x) / area, h = (one_x * rest_y - one_y * rest_x) / area;
    const double found[9] = {p[2] - p[0] + g * p[2], p[6] - p[0] + h * p[6], p[0],
                             p[3] - p[1] + g * p[3], p[7] - p[1] + h * p[7], p[1], g, h, 1};
    memcpy(to, found, sizeof found);
}

/* Where a homography maps a point of a plane. */
static inline void map_point(const double to[9], double x, double y, double mapped[2])
{
    double scale = to[6] * x + to[7] * y + to[8];
    mapped[0] = (to[0] * x + to[1] * y + to[2]) / scale;
    mapped[1] = (to[3] * x + to[4] * y + to[5]) / scale;
}

/* The covariance, (rows, rows), of what depends by a jacobian, (rows, size), on numbers with a covariance, (size,
   size). ``spare``: memory for size numbers. */
static inline void carry_covariance(const double *jacobian, int rows, const double *covariance, int size, double *carried,
                                    double *spare)
{
    for (int one = 0; one < rows; one++) {
        memset(spare, 0, size * sizeof(double));
        for (int by = 0; by < size; by++)
            for (int each = 0; each < size; each++)
                spare[each] += jacobian[size * one + by] * covariance[size * by + each];
        for (int other = 0; other < rows; other++)
            carried[rows * one + other] = dot(spare, jacobian + size * other, size);
    }
}

/* The inverse of a symmetric matrix, (3, 3). It is NAN if the matrix is not positive definite. */
static inline void invert3(const double matrix[9], double inverse[9])
{
    double factor[9];
    memcpy(factor, matrix, sizeof factor);
    int is_good = factorize(factor, 3);
    for (int row = 0; row < 3; row++) {
        double *column = inverse + 3 * row;
        for (int axis = 0; axis < 3; axis++)
            column[axis] = axis == row ? is_good ? 1 : NAN : 0;
        solve(factor, 3, column);
    }
}

/* Turn a rotation by angles about the axes that it leads to (O. Rodrigues, 1840). */
static inline void turn_rotation(const double angles[3], const double rotation[9], double turned[9])
{
    double angle = sqrt(dot(angles, angles, 3)), sine = 1, versine = 0.5;  /* divided by the angle and its square */
    if (angle > 1e-9) {  /* below that, a sine is its angle */
        double half = sin(angle / 2) / angle;
        sine = sin(angle) / angle;
        versine = 2 * half * half;
    }
    for (int column = 0; column < 3; column++) {
        double axis[3] = {rotation[column], rotation[3 + column], rotation[6 + column]}, once[3], twice[3];
        cross3(angles, axis, once);
        cross3(angles, once, twice);
        for (int row = 0; row < 3; row++)
            turned[3 * row + column] = axis[row] + sine * once[row] + versine * twice[row];
    }
}

/* The angles of a rotation about its axes, by its quaternion (S. W. Shepperd, 1978). */
static inline void rotation_angles(const double rotation[9], double angles[3])
{
    double trace = rotation[0] + rotation[4] + rotation[8], most = trace, real;
    int largest = -1;
    for (int axis = 0; axis < 3; axis++)
        if (rotation[4 * axis] > most) {
            most = rotation[4 * axis];
            largest = axis;
        }
    double off[3] = {rotation[7] - rotation[5], rotation[2] - rotation[6], rotation[3] - rotation[1]};
    if (largest < 0) {
        real = 1 + trace;
        memcpy(angles, off, sizeof off);
    } else {
        real = off[largest];
        for (int axis = 0; axis < 3; axis++)
            angles[axis] = axis == largest ? 1 + 2 * most - trace
                                           : rotation[3 * axis + largest] + rotation[3 * largest + axis];
    }
    double length = sqrt(dot(angles, angles, 3)), angle = 2 * atan2(length, fabs(real));
    double scale = length > 0 ? copysign(angle / length, real) : 0;
    for (int axis = 0; axis < 3; axis++)
        angles[axis] *= scale;
}
