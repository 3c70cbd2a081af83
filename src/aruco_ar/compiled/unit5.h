/* All that libunit5.so shows: what has the prefix unit5_.

   Only binding.py calls it, and checks all arguments; nothing is checked here. What is demanded: arrays have the
   size that is said in brackets, at most 2^31 - 1 numbers, row by row without gaps. No pointer is NULL unless that
   is said. Numbers in arrays may be any, also NaN. What returns an int returns 0 if there is not enough memory. */
#pragma once

#include "image.h"

#pragma GCC visibility push(default)

const char *unit5_version(void);  /* which sources the library was made of */

/* tag_edges.c, for edges.py, which says what is done. ``frame``: 1, 3 or 4 channels. ``quads``: (count, 4), in the
   frame. ``cells``: the width of a tag, 1 to 1000. ``wanted``: (count, cells, cells), the cells of tags that are at
   least 3 cells wide. ``samples``: of each cell, in both directions, 1 to 100. ``likeness``: (count), written. */

extern const int unit5_profile_count;
extern const float unit5_profile_positions[];  /* along an edge, from 0, where it starts, to 1 */

/* Writes ``fitted``: (count, 4), and ``good``: (count), whether all edges were found. ``whole``: NULL, or (count):
   written, what unit5_compare_tags says of the fitted tags. Only with it, ``samples`` is used, and ``wanted`` is
   changed: the cells of a tag that is white on black are negated. */
void unit5_fit_tags(const Image *frame, int count, const Point *quads, int cells, uint8_t *wanted, Point *fitted,
                    uint8_t *good, float *likeness, int samples, float *whole);

void unit5_compare_tags(const Image *frame, int count, const Point *quads, int cells, const uint8_t *wanted,
                        int samples, float *likeness);

/* ``margin``: -1000 to less than cells / 2. ``gray``: (count, cells - 2 * margin, cells - 2 * margin), written. */
void unit5_sample_cells(const Image *frame, int count, const Point *quads, int cells, int margin, float *gray);

/* ``known``: (known_count, 4). ``guesses``: (count), written. */
void unit5_guess_tags(const Image *frame, int count, const Point *quads, int cells, int known_count, const Point *known,
                      float contrast, uint8_t *guesses);

/* mask.c and warp.c, for paint.py. ``positions``: (height, width, 2), the undistorted position of each pixel of the
   mask, with ``row`` bytes from one row to the next; or NULL. */

/* Draw an area into a mask, which is black before: white inside, gray on the rim. With positions, a mask of a single
   row or column stays black. */
void unit5_draw_mask(const Image *mask, const double corners[4][2], const float *positions, int64_t row);

/* A mask is warped in blocks of this size. */
extern const int unit5_block_width, unit5_block_height;
/* A level is the picture, BGR or BGRA with colors multiplied by their alpha, halved u times across and v times down,
   each less often than this. Its number is unit5_levels * u + v. A half of an odd side leaves the last pixel out. */
extern const int unit5_levels;

/* Find which levels are needed. ``width``, ``height``: of the picture, 2 to 2^22. ``to_picture``: the homography from
   the mask to the picture. ``blocks``: written, row by row, the number of each block's level, or the square of
   unit5_levels where the mask is black. */
void unit5_find_levels(const Image *mask, int width, int height, const double to_picture[9], const float *positions,
                       int64_t row, uint16_t *blocks);

/* Warp a picture where a mask is not black. ``warped``: the result, which is black before; as large as the mask, with
   the channels of the picture. ``levels``: the one of each number that is in ``blocks``, which unit5_find_levels has
   written for the same arguments; none has more than 2^31 - 1 bytes. Beyond the picture's edges, its edge pixels are
   repeated. */
void unit5_warp_picture(const Image *warped, const Image *mask, int width, int height, const Image *levels,
                        const uint16_t *blocks, const double to_picture[9], const float *positions, int64_t row);

/* plane_poses.c, for plane_pose.py, which says what poses, weights and deviations are. */

extern const double unit5_nearest;  /* meters: an object nearer to the camera, or behind it, cannot be seen */

/* Refine both poses of each object. ``point``: (objects, points, 3), ``ray``: (objects, points, 2), ``weight``:
   (objects, points, 2, 2), ``spread``: (points, 3, deviations), the same for all objects, at most 4096 deviations.
   Changes ``rotations``: (objects, 2, 3, 3), ``translations``: (objects, 2, 3) and ``amounts``: (objects, 2,
   deviations). Writes ``squares``: (objects, 2, points) and ``covariances``: (objects, 2, 6 + deviations, 6 +
   deviations). */
int unit5_refine_pose_pairs(int64_t objects, int points, int deviations, const double *point, const double *ray,
                            const double *weight, const double *spread, double *rotations, double *translations,
                            double *amounts, double *squares, double *covariances);

/* wall.c, for difference.py and wall_model.py. */

extern const int unit5_plane_count;

/* Compare a frame with the wall; all arrays have its size. ``seen``: BGR, the frame. ``look``: BGR, the wall.
   ``whole``: the light on all of it, as factors of the look. ``contrast``: BGR, the largest differences in it near
   each pixel, in this light. ``variance``: of the noise. ``usable``: where both are known. ``darkest``,
   ``lightest``: limits of the light at a pixel, relative to that on the whole wall, in a shadow and in a spot.
   Writes ``planes``, see wall.c, which overlap nothing else, and ``front``: where something seems to stand. */
int unit5_compare_wall(const uint8_t *seen, const float *look, const float whole[3], const uint8_t *contrast,
                       const float *variance, const uint8_t *usable, int width, int height, float darkest,
                       float lightest, float *planes, uint8_t *front);

/* Learn the wall where nothing is in front. ``wall``: where the wall is seen. ``certain``: where that is sure.
   ``count``: of pixels. ``passed``: seconds since the frame before. ``settle``: the most that counts. ``rate``,
   ``variance_rate``: the weights of this frame in the running means. ``known``: where the look is known.
   ``seconds``: for how long it was seen. Changes ``look``, ``variance``, ``known`` and ``seconds``. */
void unit5_learn_wall(const uint8_t *seen, const float whole[3], const float *planes, const uint8_t *wall,
                      const uint8_t *certain, int64_t count, float passed, float settle, float rate,
                      float variance_rate, float *look, float *variance, uint8_t *known, float *seconds);

#pragma GCC visibility pop
