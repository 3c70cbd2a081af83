/* Fitting a tag to the edges between its own cells, and where these cells are. */
#pragma once

#include "image.h"

#define MIN_CONTRAST 12   /* least difference between black and white, in gray levels; less is noise */
#define MAX_BEYOND 0.25f  /* a profile is clipped where it is beyond its ends by more than this share of the contrast */

/* The homography from the unit square to a quadrilateral; see homography_to. */
typedef struct { Point right, down, start; float g, h; } Homography;

Homography homography_to(const Point quad[4]);

/* Where it maps (x, y). It is in this header, since each sample of a cell needs it. */
static inline Point mapped(const Homography *to, float x, float y)
{
    float scale = 1 / (to->g * x + to->h * y + 1);
    return (Point){(to->right.x * x + to->down.x * y + to->start.x) * scale,
                   (to->right.y * x + to->down.y * y + to->start.y) * scale};
}

/* Fit a quadrilateral to the edges between dark and light cells within a tag, (cells, cells). Returns 0 if too many
   edges are not found. ``exact``: which of its own edges are known, so that their corners stay on them; NULL if none
   is. */
int fit_cells(const Image *frame, const Point quad[4], int cells, const uint8_t *wanted, const int exact[4],
              Point fitted[4]);

enum { WHITE_TAG = 1, UNEVEN_TAG, MARGIN };

/* What a quadrilateral may be, 0 if none of these; see guess_tags in edges.py. It is looked at across its sides, at
   three places along each. ``contrast``: see there. */
int guess_tag(const Image *frame, const Point quad[4], int cells, float contrast);
