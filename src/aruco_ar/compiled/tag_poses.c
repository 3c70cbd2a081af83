/* The tags of one frame: whether each can be a square that is seen from the front, and both of its poses. */
#include "algebra.h"
#include "unit5.h"

/* The standard deviation of corners that the Detector finds, measured in front of the simulated wall: CORNER_PX, and in
   addition SMALL_TAG_PX for a tag whose shortest side is SMALL_PX. For larger tags the addition is less. */
#define CORNER_PX 0.03
#define SMALL_TAG_PX 0.05
#define SMALL_PX 20.0
#define MAX_CORNER_PX 0.5
#define SHORTEST_PX 1e-9
#define IMPOSSIBLE_COST 1e30  /* of a pose that the tag cannot have; finite, since differences of costs are taken */

/* Pixels: the standard deviation of the corners of a quadrilateral. */
static double deviation_of(const double quad[8])
{
    double sides[2] = {0, 0};
    for (int corner = 0; corner < 4; corner++) {
        const double *at = quad + 2 * corner, *next = quad + 2 * ((corner + 1) % 4);
        double x = next[0] - at[0], y = next[1] - at[1];
        sides[corner % 2] += sqrt(x * x + y * y) / 2;
    }
    double part = SMALL_PX / fmax(fmin(sides[0], sides[1]), SHORTEST_PX);
    return fmin(CORNER_PX + SMALL_TAG_PX * part * part * part, MAX_CORNER_PX);
}

/* Whether corners make a convex quadrilateral, clockwise as those of a tag that is seen from the front, and all rays to
   them are known. */
static int is_usable(const double quad[8], const double ray[8], double least)
{
    for (int axis = 0; axis < 8; axis++)
        if (!isfinite(ray[axis]))
            return 0;
    uint8_t is_convex;
    unit5_find_convex(1, quad, least, &is_convex);
    return is_convex && (quad[4] - quad[0]) * (quad[7] - quad[3]) > (quad[5] - quad[1]) * (quad[6] - quad[2]);
}

int unit5_find_tag_poses(int64_t count, const double *quads, double least, const double *rays, const double *slopes,
                         const double *sizes, uint8_t *seen, double *deviations, double *weights, double *rotations,
                         double *translations, double *covariances, double *costs)
{
    for (int64_t number = 0; number < count; number++) {
        const double *quad = quads + 8 * number, *ray = rays + 8 * number, half = sizes[number] / 2;
        double *weight = weights + 16 * number, *rotation = rotations + 18 * number, squares[8];
        double *translation = translations + 6 * number;
        double points[12] = {-half, half, 0, half, half, 0, half, -half, 0, -half, -half, 0};
        double none[1] = {0};  /* the points do not deviate */
        seen[number] = 0;
        if (!is_usable(quad, ray, least))
            continue;
        unit5_find_pose_pairs(1, 4, points, ray, rotation, translation, seen + number);
        if (!seen[number])
            continue;
        deviations[number] = deviation_of(quad);
        for (int each = 0; each < 16; each++)
            weight[each] = slopes[16 * number + each] / deviations[number];
        if (!unit5_refine_pose_pairs(1, 4, 0, points, ray, weight, none, rotation, translation, none, squares,
                                     covariances + 72 * number))
            return 0;
        seen[number] = 0;
        for (int which = 0; which < 2; which++) {
            const double *axes = rotation + 9 * which, *shift = translation + 3 * which, *square = squares + 4 * which;
            double cost = square[0] + square[1] + square[2] + square[3];
            int is_facing = axes[2] * shift[0] + axes[5] * shift[1] + axes[8] * shift[2] < 0;
            int is_possible = is_facing && shift[2] > unit5_nearest && isfinite(cost);
            costs[2 * number + which] = is_possible ? cost : IMPOSSIBLE_COST;
            seen[number] |= is_possible;
        }
    }
    return 1;
}
