/* Sizes and shapes of quadrilaterals, which are asked for several times in each frame. */
#include "algebra.h"
#include "unit5.h"

void unit5_find_sides(int64_t count, const double *quads, double *sides)
{
    for (int64_t number = 0; number < count; number++) {
        const double *quad = quads + 8 * number;
        sides[number] = 0;
        for (int corner = 0; corner < 4; corner++) {
            const double *at = quad + 2 * corner, *next = quad + 2 * ((corner + 1) % 4);
            sides[number] += hypot(next[0] - at[0], next[1] - at[1]) / 4;
        }
    }
}

void unit5_find_room(int64_t count, const double *quads, int width, int height, double *room)
{
    for (int64_t number = 0; number < count; number++) {
        room[number] = INFINITY;
        for (int corner = 0; corner < 4; corner++) {
            double x = quads[8 * number + 2 * corner], y = quads[8 * number + 2 * corner + 1];
            double least = fmin(fmin(x, width - 1 - x), fmin(y, height - 1 - y));
            room[number] = fmin(room[number], isfinite(x) && isfinite(y) ? least : -INFINITY);
        }
    }
}

void unit5_find_box(const float *positions, int64_t row, int width, int height, int step, const double to_area[9],
                    double box[4])
{
    const Positions all = {positions, row};
    box[0] = box[1] = INFINITY;
    box[2] = box[3] = -INFINITY;
    for (int y = 0; y < height; y += step)
        for (int x = 0; x < width; x += step) {
            const float *at = position_of(&all, x, y);
            double place[2];
            map_point(to_area, at[0], at[1], place);
            if (place[0] > 0 && place[0] < 1 && place[1] > 0 && place[1] < 1) {
                box[0] = fmin(box[0], x);
                box[1] = fmin(box[1], y);
                box[2] = fmax(box[2], x);
                box[3] = fmax(box[3], y);
            }
        }
}

void unit5_find_convex(int64_t count, const double *quads, double least, uint8_t *convex)
{
    for (int64_t number = 0; number < count; number++) {
        int left = 1, right = 1;
        for (int corner = 0; corner < 4; corner++) {
            const double *quad = quads + 8 * number, *at = quad + 2 * corner;
            const double *before = quad + 2 * ((corner + 3) % 4), *after = quad + 2 * ((corner + 1) % 4);
            double x = after[0] - before[0], y = after[1] - before[1];
            double height = (x * (at[1] - before[1]) - y * (at[0] - before[0])) / fmax(hypot(x, y), 1e-9);
            left &= height < -least;
            right &= height > least;
        }
        convex[number] = left || right;
    }
}
