"""What goes wrong when an area is subtracted."""
from course.corpus import Wrong
from course.wrong import HULL, SHRINK

ORDER = 'params = order_coordinates(params, False)'
MASK = 'mask = np.zeros([int(h * 0.7), int(w * 0.7), 3], dtype=np.uint8)'
FILL = 'cv2.fillConvexPoly(mask, np.int32([params]), (255, 255, 255), cv2.LINE_AA)'
SUBTRACT = 'subtraction = cv2.subtract(image, mask)'

WRONG = [
    Wrong(what='Mask and image are returned in the wrong order.',
          says='mask and image are returned in the wrong order: "return mask, image".',
          edits=[('return mask, subtraction', 'return subtraction, mask')]),
    Wrong(what='The image alone is returned.',
          says='subtract_area returned one image, but there should be 2: "return mask, image".',
          edits=[('return mask, subtraction', 'return subtraction')],
          place='Frame'),
    Wrong(what='The mask alone is returned.',
          says='subtract_area returned one image, but there should be 2: "return mask, image".',
          edits=[('return mask, subtraction', 'return mask')],
          place='Frame'),
    Wrong(what='The image is returned without subtracting.',
          says='The area is not black in your image: nothing is subtracted there. Is it what cv2.subtract '
               'returns that you return?',
          edits=[('return mask, subtraction', 'return mask, image')]),
    Wrong(what='The mask is only outlined.',
          says='Only the outline of the area is drawn in your mask. Fill it, as cv2.fillConvexPoly does, '
               'or cv2.drawContours with a thickness of -1.',
          edits=[(FILL, 'cv2.polylines(mask, np.int32([params]), True, (255, 255, 255), 2)')]),
    Wrong(what='The mask is white, with the area in black.',
          says='Your mask is the wrong way around: it is black in the area, and white elsewhere.',
          edits=[(MASK, 'mask = np.full([int(h * 0.7), int(w * 0.7), 3], 255, dtype=np.uint8)'),
                 ('(255, 255, 255)', '(0, 0, 0)')]),
    Wrong(what='The area is filled with black, on a black mask.',
          says='Your mask is black all over. Fill the area in it with white, (255, 255, 255).',
          edits=[('(255, 255, 255)', '(0, 0, 0)')]),
    Wrong(what='The area is filled with 1, which is nearly black.',
          says='Your mask is 1 where it is white. White is 255: 1 is as good as black, and so is what is '
               'subtracted.',
          edits=[('(255, 255, 255)', '(1, 1, 1)')]),
    Wrong(what='The mask has the color of exercise 5.4.',
          says='The area in your mask has the color (255, 0, 150). White is (255, 255, 255): only what is '
               'subtracted of all three makes black.',
          edits=[('(255, 255, 255)', '(255, 0, 150)')]),
    Wrong(what='A number is given as color, which is blue alone.',
          says='The area in your mask has the color (255, 0, 0). White is (255, 255, 255): only what is '
               'subtracted of all three makes black.',
          edits=[('(255, 255, 255)', '255')]),
    Wrong(what='bitwise_and keeps the area and removes the rest.',
          says='Only the area is left of your image, and the rest is black. It is the other way around: '
               'cv2.subtract(image, mask).',
          edits=[(SUBTRACT, 'subtraction = cv2.bitwise_and(image, mask)')]),
    Wrong(what='The image is subtracted from the mask.',
          says='You subtract the image from the mask. Subtract the mask from the image: '
               'cv2.subtract(image, mask).',
          edits=[(SUBTRACT, 'subtraction = cv2.subtract(mask, image)')]),
    Wrong(what='The mask is added.',
          says='The area is white in your image: the mask was added. Subtract it.',
          edits=[(SUBTRACT, 'subtraction = cv2.add(image, mask)')]),
    Wrong(what='A minus instead of cv2.subtract: below 0, bytes begin anew at 255.',
          says="The area is hardly changed, since NumPy's minus begins again at 255 if the result is below"
               ' 0. cv2.subtract(image, mask) stops at 0.',
          edits=[(SUBTRACT, 'subtraction = image - mask')]),
    Wrong(what='absdiff makes a negative of the area.',
          says='The area is a negative in your image, as from cv2.absdiff. cv2.subtract stops at 0, which '
               'is black.',
          edits=[(SUBTRACT, 'subtraction = cv2.absdiff(image, mask)')]),
    Wrong(what='The mask is of another type than the image.',
          says='the two images do not fit together: image is of the type uint8, and mask of float64. '
               'Images are of uint8: dtype=np.uint8.',
          edits=[(MASK, MASK.replace(', dtype=np.uint8', ''))],
          place='Line'),
    Wrong(what='The mask has no channels, the image has three.',
          says='the two images do not fit together: image is 448 x 336 pixels, 3 channels, and mask '
               'is 448 x 336 pixels, gray. cv2.merge([mask, mask, mask]) has three channels.',
          edits=[(MASK, MASK.replace(', 3]', ']')), ('(255, 255, 255)', '255')],
          place='Line'),
    Wrong(what='Height and width of the mask are exchanged.',
          says='the two images do not fit together: image is 448 x 336 pixels, 3 channels, and mask is 336'
               ' x 448 pixels, 3 channels. Height and width are exchanged: arrays take the height first, '
               '(h, w), but cv2.resize and cv2.warpPerspective take (w, h).',
          edits=[(MASK, MASK.replace('int(h * 0.7), int(w * 0.7)', 'int(w * 0.7), int(h * 0.7)'))],
          place='Line'),
    Wrong(what='The mask is as large as the frame, the image is smaller.',
          says='the two images do not fit together: image is 448 x 336 pixels, 3 channels, and mask is 640'
               ' x 480 pixels, 3 channels. They must be of the same size.',
          edits=[(MASK, MASK.replace('int(h * 0.7), int(w * 0.7)', 'h, w'))],
          place='Line'),
    Wrong(what='The centers are not in order.',
          says='The area in your mask is not the right one. Its rim crosses itself: its corners come in '
               'the order of the tags ….',
          edits=[('        %s\n' % ORDER, '        pass\n'),
                 (FILL, FILL.replace('fillConvexPoly', 'fillPoly'))]),
    Wrong(what='Row by row, as the homography wants it, not around.',
          says='The area in your mask is not the right one. Its rim crosses itself: its corners come in '
               'the order of the tags ….',
          edits=[(ORDER, ORDER.replace('False', 'True')), (FILL, FILL.replace('fillConvexPoly', 'fillPoly'))]),
    Wrong(what='Row by row, and fillConvexPoly makes of it what it can.',
          says='The area in your mask is not the right one. Its rim crosses itself: its corners come in '
               'the order of the tags ….',
          edits=[(ORDER, ORDER.replace('False', 'True'))]),
    Wrong(what='The hull of all corners: the tags disappear as well.',
          says="The area in your mask is not the right one. Its rim goes through the tags' outer corners, "
               'not through their centers.',
          edits=[(FILL, FILL.replace('np.int32([params])', HULL))]),
    Wrong(what='The tags are subtracted, not the area between them.',
          says='The area in your mask is not the right one. Its rim is that of the tags themselves, not of'
               ' the polygon through their centers.',
          edits=[(FILL, 'cv2.fillPoly(mask, [np.int32(c[0]) for c in corners], (255, 255, 255))')]),
    Wrong(what='An upright rectangle around the centers.',
          says='The area in your mask is not the right one. Its rim is an upright rectangle around the '
               'centers, but the area is the polygon through them.',
          edits=[(FILL, '''x, y, wide, high = cv2.boundingRect(params)
    cv2.rectangle(mask, (x, y), (x + wide, y + high), (255, 255, 255), -1)''')]),
    Wrong(what='A mask for all frames, in which the areas of earlier frames stay.',
          says='The area in your mask is not the right one. Its rim also goes around the areas of earlier '
               'frames: begin with a new black mask for each.',
          edits=[(MASK, 'mask = MASK'),
                 ('\n\ndef subtract', '\n\nMASK = np.zeros([336, 448, 3], np.uint8)\n\n\ndef subtract')]),
    Wrong(what='The area is found in the whole frame, and filled in a small mask.',
          says='The area in your mask is not the right one. Its rim is 1.43 times as far from the top left'
               ' of the image as it should be: find the tags in an image of the same size as the one that '
               'you draw on.',
          edits=[(SHRINK, ''),
                 (SUBTRACT, SHRINK.strip() + '\n    ' + SUBTRACT)]),
    Wrong(what='fillConvexPoly with fractions.',
          says='the points that cv2.fillConvexPoly draws must be whole numbers of 32 bits, a list of '
               'arrays: [np.int32(points)].',
          edits=[(FILL, FILL.replace('np.int32([params])', 'np.float32([params])'))],
          place='Line'),
    Wrong(what='The area is filled in a copy of the mask.',
          says='Your mask is black all over. Fill the area in it with white, (255, 255, 255).',
          edits=[(FILL, 'area = ' + FILL.replace('(mask,', '(mask.copy(),'))]),
    Wrong(what='The whole frame is black: the mask is white all over.',
          says='Your mask is white all over. Only the area is white, and everything else is black.',
          edits=[(FILL, 'mask[:] = 255')]),
    Wrong(what='A colored mask is published as a gray image.',
          says='your mask has three channels, but it is published as "mono8", and cv_bridge refuses that: '
               '"bgr8".',
          edits=[("cv2_to_imgmsg(output, 'bgr8')", "cv2_to_imgmsg(output, 'mono8')")],
          place='Line'),
    Wrong(what='A space more in front of a line.',
          says='this line is not indented as those around it: unexpected indent.',
          edits=[('    ' + SUBTRACT, '     ' + SUBTRACT)],
          place='Line'),
    Wrong(what='The callback publishes with a publisher that nobody has made.',
          says='mask_publisher is not known. Where is it made? A publisher, for example, is made once, in '
               'main(): "publisher = rospy.Publisher(…)".',
          edits=[('(self.mask_publisher, mask)', '(mask_publisher, mask)')],
          place='Line'),
    Wrong(what='The image has a publisher, and the mask has none.',
          says="there is one publisher, but mask and image are published, each by its own: '~mask' and "
               "'~image'.",
          edits=[("        self.mask_publisher = rospy.Publisher('~mask', Image, queue_size=1)\n", ''),
                 ('(self.mask_publisher, mask)', '(self.publisher, mask)')],
          place='Line'),
    Wrong(what='The mask is made before the image is shrunk.',
          says='your mask and image differ in size: … pixels and … pixels. If the image is resized, make the '
               'other one after that, such as np.zeros_like(image).',
          edits=[(MASK, 'mask = np.zeros([h, w, 3], dtype=np.uint8)'),
                 (SUBTRACT, 'subtraction = cv2.subtract(image, cv2.resize(mask, image.shape[1::-1]))')]),
]
