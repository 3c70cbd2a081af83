/* All that the library shows: what has the prefix unit5_.

   Only binding.py calls it, and checks all arguments; nothing is checked here. What is demanded: arrays have the
   size that is said in brackets, at most 2^31 - 1 numbers, row by row without gaps. No pointer is NULL unless that
   is said. Numbers in arrays may be any, also NaN. What returns an int returns 0 if there is not enough memory. */
#pragma once

#include "image.h"

#ifdef _WIN32
#pragma clang attribute push(__attribute__((dllexport)), apply_to = any(function, variable(is_global)))
#else
#pragma GCC visibility push(default)
#endif

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

/* quads.c and tag_reading.c, for quads.py. */

extern const int unit5_widest_window;

/* Find quadrilaterals in a gray image, clockwise. ``window``: an odd number, 3 to unit5_widest_window. ``shortest``: the
   least sum of the sides. ``quads``: (room, 4), written. Returns how many there are, which may be more than ``room``,
   or -1 if there is not enough memory. */
int64_t unit5_find_quads(const Image *image, int window, float shortest, int64_t room, Point *quads);

/* Read the tags in quadrilaterals. ``cells``: the width of a tag, with its border on both sides, ``border`` cells wide,
   1 to 10, and 1 to 8 cells within. ``dictionary``: (words, 4), the cells within the border as bits, row by row, the
   first one lowest, as they are seen from each of the tag's corners. ``corrected``: how many cells may be wrong.
   ``contrast``: the least one of the border of a tag that is white on black with what is around it, gray levels.
   ``ids``: (count), written, -1 for no tag, -2 for no tag that is sure, or not the best reading of it. Changes
   ``quads``: (count, 4), those of tags begin at their own top left. */
int unit5_read_tags(const Image *frame, int count, Point *quads, int cells, int border, int words,
                    const uint64_t *dictionary, int corrected, float contrast, int *ids);

/* shapes.c, for edges.py, ordering.py and area.py. ``quads``: (count, 4, 2). */

/* ``sides``: (count), written, the mean side of each. */
void unit5_find_sides(int64_t count, const double *quads, double *sides);

/* ``room``: (count), written, how far each is within a frame of that size, pixels; negative if a corner is outside. */
void unit5_find_room(int64_t count, const double *quads, int width, int height, double *room);

/* Write ``box``: the least x and y, and the greatest ones, of every ``step``-th pixel in both directions that is in an
   area; the least are infinite if none is. ``positions``: (height, width, 2), the undistorted position of each pixel, with
   ``row`` bytes from one row to the next. ``to_area``: the homography from there to the area, the unit square. */
void unit5_find_box(const float *positions, int64_t row, int width, int height, int step, const double to_area[9],
                    double box[4]);

/* ``convex``: (count), written, whether all corners are more than ``least`` away from the line through their two
   neighbors, on the same side. */
void unit5_find_convex(int64_t count, const double *quads, double least, uint8_t *convex);

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

/* motion.c, for motion.py, which says what is done. */

/* An area's corners, x and y of each, their speeds, and the covariance of both, in pixels and seconds. ``biased``: the
   corners' errors due to the biases, which are the same in every frame; each column is for one coordinate of one of a
   tag's four corners. ``middle``: of the frame. ``focal``: the assumed focal length. All are finite numbers. */
typedef struct { double place[8], speed[8], covariance[16][16], biased[8][8], middle[2], focal; } Motion;

/* Start with a place and a middle. A measurement is of ``count`` points, four for each tag, at least 4. ``points``:
   (count, 2), in the plane of the area. ``pixels``: (count, 2). ``deviation``, ``bias``: (count). */
void unit5_start_motion(Motion *motion, int64_t count, const double *points, const double *deviation,
                        const double *bias);

void unit5_predict_motion(Motion *motion, double seconds, int calm);

void unit5_jerk_motion(Motion *motion);

/* Returns 0, and changes nothing, if the measurement is more unlikely than the limit. */
int unit5_correct_motion(Motion *motion, int64_t count, const double *points, const double *pixels,
                         const double *deviation, const double *bias, double limit);

/* ``deviation``: (4), written. */
void unit5_find_deviation(const Motion *motion, double deviation[4]);

double unit5_unlikeliness(const Motion *motion, int64_t count, const double *points, const double *pixels,
                          const double *deviation);

/* ``points``: (count, 2). ``pixels``: (count, 2), written. */
void unit5_project(const Motion *motion, int64_t count, const double *points, double *pixels);

/* align.c, for texture.py. ``image``: (height, width), gray, and at least 2^(unit5_wall_levels - 1) pixels each way.
   Positions are relative to its middle, in halves of its width. ``patches``: (wall_levels, count, patch_size). */

extern const int unit5_wall_levels, unit5_patch_width, unit5_patch_size;

/* Write ``patches``: what the image shows around ``points``, (count, 2). */
int unit5_learn_patches(float *image, int width, int height, int count, const double *points, float *patches);

/* Align patches of the wall with an image in which it is seen. ``places``: (count, 2), of the patches on the wall.
   ``usable``: (count), which of them are used. ``coarsest``: the level to begin with, less than wall_levels; 0 is the
   finest. ``only_compare``: whether they stay where they are. For these levels, writes ``warps``: (wall_levels, 3, 3),
   the homography from the wall to the image, as it is known after each of them; ``likeness``: (wall_levels, count), the
   correlations; and ``off``: (wall_levels, count, 2), how many pixels of that level each patch alone is off. */
int unit5_align_patches(float *image, int width, int height, int count, const float *patches, const double *places,
                        const uint8_t *usable, int coarsest, int only_compare, double *warps, float *likeness,
                        float *off);

/* mix.c, for paint.py. All images are of one size. ``window`` and ``mask`` are BGR, ``picture`` is BGR or BGRA.
   ``opacity``: 0 to 255. Writes ``hidden`` and ``shown``: (height, width, 3), the window's and the picture's colors,
   multiplied by how much the picture covers. */
void unit5_mix_picture(const Image *window, const Image *picture, const Image *mask, int opacity, uint8_t *hidden,
                       uint8_t *shown);

/* light.c, for hanging.py. */

extern const int unit5_light_step;  /* pixels from one at which the light is known to the next, across and down */

/* Change a picture, BGR or BGRA, as if it was printed and hung in a light, where a mask, BGR, is not black. ``white``:
   BGR, the level of white paper in the middle of each square of light_step pixels; at least one, and enough of them for
   the picture. ``black``: the level of ink, 0 to 255, as a share of that of paper. */
int unit5_light_picture(const Image *picture, const Image *mask, const Image *white, int black);

/* soften.c, for grain.py. Blur a picture, BGR, and its mask, BGR, of one size, by a normal distribution. ``across``,
   ``down``: its deviation, pixels. Writes ``softened`` and ``share``: (height, width, 3), the colors and the mask; where
   they remain black, they are not written. */
int unit5_soften_picture(const Image *picture, const Image *mask, double across, double down, uint8_t *softened,
                         uint8_t *share);

/* ring.c, for ring.py. */

extern const int unit5_ring_places;  /* number of colors of a ring along each side */

/* Write ``ways``: (count, 4, places, 2, 2), the ways out from each place on the sides of ``quads``: (count, 4, 2),
   clockwise: their ends inside and outside. Neither a lens nor a slant bends them much. */
void unit5_find_ways(int count, const double *quads, double *ways);

/* Read what is beside the sides of ``quads``: (count, 4, 2), undistorted pixels, and find out where their blur ends, and
   the ground. ``frame``: BGR, not empty. ``ways``: as above, but pixels of the frame. Writes ``colors``: (count, 4, places,
   3), of the ground, ``shown``: (count, 4, places), whether the frame shows that, ``corners``: (count, 4, 2), the
   quadrilaterals, grown by their blur, and ``reaches``: (count, 2), pixels, how far out the blur reaches, and the ground,
   on all sides but the worst one. */
void unit5_read_rings(const Image *frame, int count, const double *quads, const double *ways, double *colors,
                      uint8_t *shown, double *corners, double *reaches);

/* Write ``even``: (count, 4 * places, 3), the colors of rings, of the same shape, without those of things in front and of
   other tags. ``shown``: as above. ``usual``: of the same shape, the colors of before, or NAN if they are unknown;
   then most of the ring has about one color. Light changes all channels by about the same factor, and less than a thing does.
   What is left out is filled in from the colors beside it, in the light of now. Where ``seen``, (count), is not 0, the
   usual colors are learned. */
void unit5_even_rings(int count, const double *colors, const uint8_t *shown, const uint8_t *seen, double *usual,
                      double *even);

/* roughness.c, for roughness.py. */

extern const double unit5_seam;  /* the width of the strip in which two tiles are mixed, in tiles */

/* Draw a cover where ``mask``, of the image's size, is not black: what is smooth, ``cover``, and what is not, in
   ``count`` rows and columns of tiles. Elsewhere, the image, 3 or 4 channels, is left as it is. ``positions``, ``row``:
   those of its pixels; see Positions. ``left``, ``top``: where its first pixel is in the ``frame``, BGR. ``cover``:
   (rows, columns, 4), at least 2 each way. ``to_cover``: (3, 3), from undistorted pixels to the unit square, which the
   cover fills. ``to_tiles``: (3, 3), from undistorted pixels to the square from 0 to ``count``; beyond it, the cover is
   smooth.
   ``shifts``: (count, count, 2), x and y, pixels, from each tile to its source in the frame. ``smooth``: (count, count,
   3, 4), the smooth part of that source: its color, and what is added per tile to the right and down, BGR and 0. */
void unit5_draw_cover(const Image *image, const Image *mask, const float *positions, int64_t row, int left, int top,
                      int rows, int columns, const float *cover, const double to_cover[9], const Image *frame,
                      int count, const double to_tiles[9], const int *shifts, const float *smooth);

extern const int unit5_most_sources;
extern const double unit5_dark;  /* gray levels to add to colors before their ratios are taken */

/* Choose a source for each tile. ``frame``: BGR. ``middles``: (tiles, 2), of the tiles, and ``at``: (count, 3, 2), the
   middle of each source, and the places one tile right of it and below; pixels of the frame. ``frames``: at least 1, of
   the mean that is ``usual``: (count, 4), the color and the roughness of each source, or -1 if that is unknown. The first
   frame begins it; later, it is changed if ``learns`` is not 0. ``order``: (tiles, count): the usable source with the
   least of these is chosen. Changes ``shifts``: (tiles, 2), pixels, from each tile to its source; a shift that is off by
   less than ``stays``, each way, stays. Writes ``smooth``: (tiles, 3, 4), as above. Returns whether enough sources are
   usable; if not, it does neither. */
int unit5_choose_sources(const Image *frame, int count, const double *middles, const double *at, int frames, int learns,
                         float *usual, int tiles, const float *order, double stays, int *shifts, float *smooth);

/* plane_poses.c, for plane_pose.py, which says what poses, weights and deviations are. */

extern const double unit5_nearest;  /* meters: an object nearer to the camera, or behind it, cannot be seen */

/* first_poses.c, for plane_pose.py, too. Find both poses of each object. ``point``: (objects, points, 3), whose z is 0.
   ``ray``: (objects, points, 2). Writes ``rotations``: (objects, 2, 3, 3), ``translations``: (objects, 2, 3), and
   ``posed``: (objects), whether there are any. */
void unit5_find_pose_pairs(int64_t objects, int points, const double *point, const double *ray, double *rotations,
                           double *translations, uint8_t *posed);

/* Refine both poses of each object. ``point``: (objects, points, 3), ``ray``: (objects, points, 2), ``weight``:
   (objects, points, 2, 2), ``spread``: (points, 3, deviations), the same for all objects, at most 4096 deviations.
   Changes ``rotations``: (objects, 2, 3, 3), ``translations``: (objects, 2, 3) and ``amounts``: (objects, 2,
   deviations). Writes ``squares``: (objects, 2, points) and ``covariances``: (objects, 2, 6 + deviations, 6 +
   deviations). */
int unit5_refine_pose_pairs(int64_t objects, int points, int deviations, const double *point, const double *ray,
                            const double *weight, const double *spread, double *rotations, double *translations,
                            double *amounts, double *squares, double *covariances);

/* tag_poses.c, for estimator.py. The tags at ``quads``: (count, 4, 2), whose corners are more than ``least`` away from
   the line through their two neighbors. ``rays``: (count, 4, 2), ``slopes``: (count, 4, 2, 2), the derivatives of the
   pixels by them, ``sizes``: (count), meters. Writes ``seen``: (count), whether the tag can be there. Of such tags, it
   writes ``deviations``: (count), ``weights``: (count, 4, 2, 2), both poses, and ``costs``: (count, 2). */
int unit5_find_tag_poses(int64_t count, const double *quads, double least, const double *rays, const double *slopes,
                         const double *sizes, uint8_t *seen, double *deviations, double *weights, double *rotations,
                         double *translations, double *covariances, double *costs);

/* beliefs.c, for belief.py. Poses are ``rotations``: (count, 3, 3), ``translations``: (count, 3), and ``covariances``:
   (count, 6, 6). */

extern const int unit5_belief_size;

/* For both poses of each object: (count, 2, ...). ``costs``: (count, 2), the squared errors. ``now``: seconds. Changes
   ``memories``: (count, belief_size), NAN for a new object. Writes ``believed``: (count), 0 or 1, and ``weights``:
   (count), of the other pose. */
void unit5_weigh_poses(int64_t count, const double *rotations, const double *translations, const double *covariances,
                       const double *costs, double now, double *memories, int64_t *believed, double *weights);

/* Write ``mixed``: (count, 6, 6), the covariances of poses that allow for the other poses. Changes ``weights``: (count),
   of the other poses: 0 if the two cannot be told apart. */
void unit5_mix_poses(int64_t count, const double *rotations, const double *translations, const double *covariances,
                     const double *other_rotations, const double *other_translations, const double *other_covariances,
                     double *weights, double *mixed);

/* flat_walls.c, for observations.py and flatness.py. */

extern const int unit5_flatness_size;

/* The poses of tags by both poses of their wall: (2, ...), with ``amounts``: (2, deviations), and ``wall_covariances``:
   (2, 6 + deviations, 6 + deviations). The tags' poses on it are ``rotations``: (count, 3, 3), ``centers``: (count, 3),
   and ``spread``: (count, 6, deviations), how they deviate. Writes poses: (count, 2, ...). */
int unit5_place_tags(int64_t count, int deviations, const double *wall_rotations, const double *wall_translations,
                     const double *amounts, const double *wall_covariances, const double *rotations,
                     const double *centers, const double *spread, double *tag_rotations, double *tag_translations,
                     double *covariances);

/* ``axes`` and ``bulge``: (3, 3). Writes ``off``: (count, 3), and ``spread``: (count, 3, 3). */
int unit5_off_others(int64_t count, const double *rotations, const double *translations, const double *covariances,
                     const double axes[9], const double bulge[9], double *off, double *spread);

/* ``off``: (count, 3), ``spread``: (count, 3, 3). Changes ``memories``: (count, flatness_size), 0 for a new tag.
   Writes ``squared``: (count). */
void unit5_add_off(int64_t count, const double *off, const double *spread, double *memories, double *squared);

/* wall.c, for difference.py and wall_model.py. */

extern const int unit5_plane_count;

/* Measure the light on the whole wall, by a few of the pixels that are usable, and had nothing in front in the frame
   before. ``seen``: BGR, the frame. ``look``: BGR, the wall. ``light``: that before, as factors of the look, and then the
   one now. Writes ``unshaded``: the light outside of shadows. If too few pixels show the light, it stays as it was, and
   ``unshaded`` is -1. */
int unit5_measure_light(const uint8_t *seen, const float *look, const uint8_t *usable, const uint8_t *front, int width,
                        int height, float light[3], float *unshaded);

/* Write ``wall``: (count), BGR, how a wall of that ``look``, (count), BGR, looks in the light ``whole``. */
void unit5_light_wall(const float *look, const float whole[3], int64_t count, uint8_t *wall);

/* Compare a frame with the wall; all arrays have its size. ``seen``: BGR, the frame. ``look``: BGR, the wall.
   ``whole``: the light on all of it, as factors of the look. ``contrast``: BGR, the largest differences in the look
   near each pixel. ``variance``: of the noise. ``usable``: where both are known. ``darkest``,
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

#ifdef _WIN32
#pragma clang attribute pop
#else
#pragma GCC visibility pop
#endif
