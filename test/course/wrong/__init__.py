"""Wrong solutions, a file for each exercise, and edits of the course's code that are in several of them."""

# Tags are found in the shrunk frame, but the whole one is drawn on; and the other way around.
DRAWN_ON_WHOLE = [('image = cv2.resize(image,', 'small = cv2.resize(image,'),
                  ('cvtColor(image', 'cvtColor(small')]
SHRINK = '    image = cv2.resize(image, (int(w * 0.7), int(h * 0.7)))\n'
# All corners of all tags.
HULL = 'cv2.convexHull(np.concatenate(corners, axis=1)[0].astype(int))'
