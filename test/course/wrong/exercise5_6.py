"""What goes wrong when a picture is painted into an area."""
from course.corpus import Wrong
from course.wrong import DRAWN_ON_WHOLE

CORNERS = '[[0, 0], [width, 0], [0, height], [width, height]]'
HOMOGRAPHY = 'hom, status = cv2.findHomography(coordinates, params_2)'
WARP = 'warped_image = cv2.warpPerspective(paint, hom, (int(w * 0.7), int(h * 0.7)))'
FILL = 'cv2.fillConvexPoly(mask, np.int32([params]), (255, 255, 255), cv2.LINE_AA)'
SUBTRACT = 'subtraction = cv2.subtract(image, mask)'
ADD = 'addition = cv2.add(warped_image, subtraction)'

WRONG = [
    Wrong(what="The picture's corners go around, the centers row by row.",
          says="Your picture is twisted: its corners go to the tags …, in the order top left, top "
               "right, bottom right, bottom left. List the picture's corners and the centers in the "
               "same order…",
          edits=[(CORNERS, '[[0, 0], [width, 0], [width, height], [0, height]]')]),
    Wrong(what="The picture's corners are row by row, the centers around.",
          says="Your picture is twisted: its corners go to the tags …, in the order top left, top "
               "right, bottom right, bottom left. List the picture's corners and the centers in the "
               "same order…",
          edits=[(HOMOGRAPHY, HOMOGRAPHY.replace('params_2', 'params'))]),
    Wrong(what='The picture is mirrored.',
          says='Your picture is mirrored: its left and its right are exchanged…',
          edits=[(CORNERS, '[[width, 0], [0, 0], [width, height], [0, height]]')]),
    Wrong(what='The picture is upside down and mirrored: its bottom corners come first.',
          says='Your picture is upside down and mirrored: its top and its bottom are exchanged…',
          edits=[(CORNERS, '[[0, height], [width, height], [0, 0], [width, 0]]')]),
    Wrong(what='The picture is upside down: its corners come in the opposite order.',
          says='Your picture is upside down: it is turned by 180 degrees…',
          edits=[(CORNERS, '[[width, height], [0, height], [width, 0], [0, 0]]')]),
    Wrong(what='The picture is turned by a quarter.',
          says='Your picture is turned by a quarter, counterclockwise: its top left corner is at the '
               'bottom left…',
          edits=[(CORNERS, '[[width, 0], [width, height], [0, 0], [0, height]]')]),
    Wrong(what="x and y of the picture's corners are exchanged.",
          says='Your picture is mirrored and turned: its rows are columns. Are x and y exchanged…',
          edits=[(CORNERS, '[[0, 0], [0, height], [width, 0], [width, height]]')]),
    Wrong(what='Width and height of the picture are exchanged.',
          says="Your picture is stretched: its width and height are exchanged. An array's shape is "
               '(height, width), and a corner is (x, y), so the bottom right one is (width, height).',
          edits=[('height, width = paint.shape[:2]', 'width, height = paint.shape[:2]')]),
    Wrong(what='The homography goes the other way.',
          says="The homography goes the wrong way, from the area to the picture. Take the picture's "
               "corners first, then the centers.",
          edits=[(HOMOGRAPHY, 'hom, status = cv2.findHomography(params_2, coordinates)')]),
    Wrong(what='The size for warpPerspective is height, width.',
          says='the two images do not fit together: warped_image is 336 x 448 pixels, 3 channels, and '
               'subtraction is 448 x 336 pixels, 3 channels. Height and width are exchanged: arrays take '
               'the height first, (h, w), but cv2.resize and cv2.warpPerspective take (w, h).',
          edits=[(WARP, WARP.replace('(int(w * 0.7), int(h * 0.7))', '(int(h * 0.7), int(w * 0.7))'))],
          place='Line'),
    Wrong(what='The size for warpPerspective is that of the whole frame.',
          says='the two images do not fit together: warped_image is 640 x 480 pixels, 3 channels, and '
               'subtraction is 448 x 336 pixels, 3 channels. They must be of the same size.',
          edits=[(WARP, WARP.replace('(int(w * 0.7), int(h * 0.7))', '(w, h)'))],
          place='Line'),
    Wrong(what='The size for warpPerspective is that of the picture.',
          says='the two images do not fit together: warped_image is 240 x 320 pixels, 3 channels, and '
               'subtraction is 448 x 336 pixels, 3 channels. They must be of the same size.',
          edits=[(WARP, WARP.replace('(int(w * 0.7), int(h * 0.7))', '(width, height)'))],
          place='Line'),
    Wrong(what='The picture is added without subtracting the area.',
          says='The picture is added to the wall, which shines through and makes it too bright. Subtract '
               'the area first, as in exercise 5.5.',
          edits=[(ADD, ADD.replace('subtraction', 'image'))]),
    Wrong(what='The warped picture alone is returned.',
          says='Only the picture is to be seen, and everything around it is black. Add it to the frame of '
               'which the area was subtracted.',
          edits=[('return addition', 'return warped_image')]),
    Wrong(what='The area is black: the picture is not added.',
          says='The area is black, and there is no picture in it. Is the warped picture added? And do its '
               'corners go to the centers in the same order?',
          edits=[('return addition', 'return subtraction')]),
    Wrong(what='The frame is returned.',
          says='Your image is the frame as it came, and there is no picture in it. Is it the result '
               'that you return?',
          edits=[('return addition', 'return image')]),
    Wrong(what='Picture and frame are mixed half and half.',
          says='The picture is half transparent: the wall shines through. Make the area black first, as in'
               ' exercise 5.5, then add the picture.',
          edits=[(ADD, 'addition = cv2.addWeighted(image, 0.5, warped_image, 0.5, 0)')]),
    Wrong(what='A plus instead of cv2.add, and nothing subtracted: above 255, bytes begin anew at 0.',
          says="NumPy's plus and minus begin again at 0 and 255. Subtract the mask with cv2.subtract, and "
               'add the picture with cv2.add.',
          edits=[(ADD, 'addition = image + warped_image')]),
    Wrong(what='The mask is outside of the area.',
          says='Only the area is left of your image, and the rest is black: the mask is the wrong way around.',
          edits=[(SUBTRACT, 'subtraction = cv2.subtract(image, 255 - mask)')]),
    Wrong(what="The picture's black is left out: the frame shines through its night.",
          says='Where the picture is dark, the wall shines through. Make all of the area black before you '
               'add the picture.',
          edits=[(ADD, 'addition = np.where(warped_image > 0, warped_image, image)')]),
    Wrong(what='Red and blue of the picture are exchanged.',
          says="Your picture's colors are exchanged: its red is blue. OpenCV's images are blue, green, red.",
          edits=[('paint = picture', 'paint = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)')]),
    Wrong(what='Red and blue of the result are exchanged.',
          says='The colors of your image are exchanged: blue is red, and red is blue.',
          edits=[('return addition', 'return cv2.cvtColor(addition, cv2.COLOR_BGR2RGB)')]),
    Wrong(what='The picture is gray, the frame has colors.',
          says='the two images do not fit together: warped_image is 448 x 336 pixels, gray, and '
               'subtraction is 448 x 336 pixels, 3 channels. cv2.merge([warped_image, warped_image, '
               'warped_image]) has three channels.',
          edits=[('paint = picture', 'paint = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)')],
          place='Line'),
    Wrong(what='The picture is painted gray.',
          says='Your picture has no colors: it is gray.',
          edits=[('paint = picture', 'paint = cv2.merge(3 * [cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)])')]),
    Wrong(what='The picture is pasted into an upright rectangle, not warped.',
          says='Your picture is not in the right area. Its rim is an upright rectangle around the centers,'
               ' but the area is the polygon through them.',
          edits=[(ADD, '''addition = image
    x, y, wide, high = cv2.boundingRect(params)
    addition[y:y + high, x:x + wide] = cv2.resize(paint, (wide, high))''')]),
    Wrong(what='An affine transformation knows three of the four corners.',
          says='Your picture is a parallelogram, as from three of the centers. Four points and '
               'cv2.warpPerspective let far sides be shorter.',
          edits=[(HOMOGRAPHY, 'hom = cv2.getAffineTransform(*np.float32([coordinates[:3], params_2[:3]]))'),
                 (WARP, WARP.replace('warpPerspective', 'warpAffine'))]),
    Wrong(what='The centers are not in order.',
          says="Your picture is twisted: its corners go to the tags …, in the order top left, top "
               "right, bottom right, bottom left. List the picture's corners and the centers in the "
               "same order…",
          edits=[('params_2 = order_coordinates(params, True)', 'params_2 = params'),
                 ('params = order_coordinates(params, False)', 'pass')]),
    Wrong(what='The first corners of the tags instead of their centers.',
          says="Your picture is not in the right area. Its rim goes through the tags' first corners, "
               'corner[0], not through their centers: the center is the mean of all four.',
          edits=[('params.append((int(c[:, 0].mean()), int(c[:, 1].mean())))',
                  'params.append((int(c[0][0]), int(c[0][1])))')]),
    Wrong(what='findHomography returns two things, and both are taken for the homography.',
          says='hom has two things in it, since cv2.findHomography returns two: "hom, status = …".',
          edits=[('hom, status =', 'hom =')],
          place='Line'),
    Wrong(what='getPerspectiveTransform with whole numbers.',
          says='cv2.getPerspectiveTransform needs as many points on both sides, four each, as arrays '
               'of 4 x 2 numbers of float32: np.float32(points).',
          edits=[(HOMOGRAPHY, 'hom = cv2.getPerspectiveTransform(coordinates, params_2)')],
          place='Line'),
    Wrong(what="The picture is read from a path of the course's own machine.",
          says='an image is read from a file here, but picture, which is given to the function, is '
               'not used. Leave this line out, and write picture below wherever this image is meant.',
          edits=[('paint = picture', "paint = cv2.imread('/home/user/catkin_ws/src/unit5/earth.jpg')")],
          place='Line'),
    Wrong(what='The area is found in the small frame, and painted in the whole one.',
          says='Your picture is not in the right area. Its rim is 0.7 times as far from the top left of '
               'the image as it should be: find the tags in an image of the same size as the one that you '
               'draw on.',
          edits=[*DRAWN_ON_WHOLE,
                 (WARP, WARP.replace('(int(w * 0.7), int(h * 0.7))', '(w, h)')),
                 ('[int(h * 0.7), int(w * 0.7), 3]', '[h, w, 3]')]),
    Wrong(what='A gray image as it comes is taken for one of colors: passthrough.',
          says='imgmsg_to_cv2 is not told an encoding, so the frame comes as the camera sends it, mostly '
               'with red first, and goes out as "bgr8": red and blue are exchanged. Give it "bgr8".',
          edits=[("desired_encoding='bgr8'", "desired_encoding='passthrough'")],
          place='Line'),
    Wrong(what='The node is made while the file is imported.',
          says='rospy.init_node is called while the file is imported. What the node does belongs into '
               'main(), which is called below "if __name__ == \'__main__\':".',
          edits=[("    rospy.init_node('my_exercise5_6')\n", ''),
                 ('\n\ndef order_', "\nrospy.init_node('my_exercise5_6')\n\n\ndef order_")],
          place='Line'),
    Wrong(what='The library is called OpenCV, but its module cv2.',
          says='there is no module opencv: it is "import cv2".',
          edits=[('import cv2\n', 'import opencv as cv2\n')],
          place='Line'),
    Wrong(what='The centers are taken as they were found.',
          says='Your picture is …. That is also the order in which the tags were found: are the '
               'centers in order?',
          edits=[('        params_2 = order_coordinates(params, True)\n', ''),
                 ('    params = np.array(params)\n', '    params = params_2 = np.array(params)\n')]),
    Wrong(what='Width and height are exchanged, and nothing is subtracted yet.',
          says="Your picture is stretched: its width and height are exchanged. An array's shape is (height, "
               'width), and a corner is (x, y), so the bottom right one is (width, height).',
          edits=[('height, width = paint.shape[:2]', 'width, height = paint.shape[:2]'),
                 ('cv2.add(warped_image, subtraction)', 'cv2.add(warped_image, image)')]),
]
