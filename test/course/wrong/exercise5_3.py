"""What goes wrong when centers are extracted."""
from course.corpus import Wrong
from course.wrong import DRAWN_ON_WHOLE, HULL, SHRINK

APPEND = 'params.append((int(c[:, 0].mean()), int(c[:, 1].mean())))'
CIRCLE = '        cv2.circle(image, (int(c[:, 0].mean()), int(c[:, 1].mean())), 3, (255, 255, 0), -1)\n'
DRAW = 'cv2.drawContours(image, [params], -1, (255, 0, 150), -1)'

WRONG = [
    Wrong(what='The first corner of each tag instead of its center.',
          says="your polygon goes through the tags' first corners, not through their centers. A center is "
               'the mean of the four corners.',
          edits=[(APPEND, 'params.append((int(c[0][0]), int(c[0][1])))')]),
    Wrong(what='The middle of the top side instead of the center.',
          says="your polygon goes through the middles of the tags' sides, not through their centers. A "
               'center is the mean of the four corners.',
          edits=[(APPEND, 'params.append((int((c[0][0] + c[1][0]) / 2), int((c[0][1] + c[1][1]) / 2)))')]),
    Wrong(what='The sum of the corners is divided by 2, not 4.',
          says='your polygon is twice as far from the top left as it should be. The mean of four corners '
               'is their sum divided by 4.',
          edits=[(APPEND, 'params.append((int(c[:, 0].sum() / 2), int(c[:, 1].sum() / 2)))')]),
    Wrong(what='The same tag in each turn of the loop.',
          says='your polygon does not reach the centers of the tags …. Is only one center kept: is '
               'append in the loop, or behind it?',
          edits=[('c = corners[i][0]', 'c = corners[0][0]')]),
    Wrong(what='x is used for y as well.',
          says='x is taken for y, too: of a point, [0] is x, and [1] is y.',
          edits=[(APPEND, 'params.append((int(c[:, 0].mean()), int(c[:, 0].mean())))')]),
    Wrong(what='x and y are exchanged.',
          says='x and y are exchanged. Drawing functions take (x, y), while an array has the row, which is'
               ' y, first.',
          edits=[(APPEND, 'params.append((int(c[:, 1].mean()), int(c[:, 0].mean())))')]),
    Wrong(what='append stands behind the loop, so only the last center is kept.',
          says='there are only points at the centers, and no polygon. Is one drawn, as a list of '
               'polygons ([points]), and on the image that you return? Are all four centers in it: is'
               ' append in the loop, or behind it?',
          edits=[('        ' + APPEND, '    ' + APPEND)]),
    Wrong(what='The list is emptied in each turn of the loop.',
          says='there are only points at the centers, and no polygon. Is one drawn, as a list of '
               'polygons ([points]), and on the image that you return? Are all four centers in it: is'
               ' append in the loop, or behind it?',
          edits=[('        c = corners[i][0]', '        params = []\n        c = corners[i][0]')]),
    Wrong(what='Three of four tags: range(3).',
          says='your polygon has only three corners, so one center is missing, or another is taken twice.',
          edits=[('range(len(ids))', 'range(3)')]),
    Wrong(what='The first tag is left out: range(1, len(ids)).',
          says='your polygon has only three corners, so one center is missing, or another is taken twice.',
          edits=[('range(len(ids))', 'range(1, len(ids))')]),
    Wrong(what='Centers as fractions of a pixel, where OpenCV wants whole numbers.',
          says='cv2.drawContours wants whole numbers, of int32, and params is of float32: [np.int32(params)].',
          edits=[(APPEND, 'params.append((c[:, 0].mean(), c[:, 1].mean()))')],
          place='Line'),
    Wrong(what='A list of points where OpenCV wants a list of polygons.',
          says='cv2.drawContours wants a list of polygons, with brackets around each: [np.int32(params)].',
          edits=[(DRAW, DRAW.replace('[params]', 'params'))],
          place='Line'),
    Wrong(what='Circles only, no polygon.',
          says='there are only points at the centers, and no polygon. Is one drawn, as a list of '
               'polygons ([points]), and on the image that you return? Are all four centers in it: is'
               ' append in the loop, or behind it?',
          edits=[('    %s\n' % DRAW, '')]),
    Wrong(what='The polygon goes to a copy, and the frame is returned.',
          says='there are only points at the centers, and no polygon. Is one drawn, as a list of '
               'polygons ([points]), and on the image that you return? Are all four centers in it: is'
               ' append in the loop, or behind it?',
          edits=[(DRAW, DRAW.replace('image', 'image.copy()'))]),
    Wrong(what='Found in the small frame, drawn on the whole one.',
          says='your polygon is too near to the top left: the centers were found in a frame that was '
               'shrunk to 0.7, but drawn on the whole frame. Find and draw in the same image.',
          edits=DRAWN_ON_WHOLE),
    Wrong(what='Found in the whole frame, drawn on the small one.',
          says='your polygon is too far to the right and too low: the centers were found in the whole '
               'frame, but drawn on one that was shrunk to 0.7. Find and draw in the same image.',
          edits=[(SHRINK, ''),
                 ('    params = []\n', '    params = []\n' + SHRINK)]),
    Wrong(what='The mean of all centers: a single point.',
          says='there are only points at the centers, and no polygon. Is one drawn, as a list of '
               'polygons ([points]), and on the image that you return? Are all four centers in it: is'
               ' append in the loop, or behind it?',
          edits=[('params = np.array(params)', 'params = np.array(params).mean(axis=0).astype(int)[None]')]),
    Wrong(what='An upright rectangle around the centers.',
          says='you draw an upright rectangle. Its corners should be the four centers.',
          edits=[(DRAW, '''x, y, wide, high = cv2.boundingRect(params)
    cv2.rectangle(image, (x, y), (x + wide, y + high), (255, 0, 150), -1)''')]),
    Wrong(what='All sixteen corners make the polygon.',
          says='your polygon goes through all corners of all tags, not through the four centers. A center '
               'is the mean of the four corners.',
          edits=[(DRAW, DRAW.replace('[params]', '[np.concatenate(corners, axis=1)[0].astype(int)]'))]),
    Wrong(what='The hull of all corners, outside of the tags.',
          says='your polygon goes around all tags, through their outermost corners, not through their '
               'centers. A center is the mean of the four corners.',
          edits=[(DRAW, DRAW.replace('params', HULL))]),
    Wrong(what='Every tag is filled, and nothing joins them.',
          says='you draw the tags, but no polygon through their four centers.',
          edits=[(DRAW, DRAW.replace('[params]', '[c[0].astype(int) for c in corners]'))]),
    Wrong(what='return stands in the loop, so it ends with the first tag.',
          says='your polygon does not reach the centers of the tags …. Is only one center kept: is '
               'append in the loop, or behind it?',
          edits=[('    params = np.array(params)\n', '        return image\n    params = np.array(params)\n')]),
    Wrong(what='The coordinates are returned instead of the image.',
          says='extract_centers returned an array of the shape (4, 2), which looks like points or a '
               'matrix, not like an image.',
          edits=[('    return image', '    return params')]),
    Wrong(what='A black image with the polygon, instead of the frame.',
          says='What you drew is on a black image. Draw it on the frame.',
          edits=[(DRAW, 'image = np.zeros_like(image)\n    ' + DRAW)]),
    Wrong(what='A corner lacks an index: the corners of a tag are in an array of their own.',
          says='corners[i] is an array of 1 x 4 x 2 numbers, so one [0] is missing: the four corners of a '
               'tag are corners[i][0].',
          edits=[('c = corners[i][0]', 'c = corners[i]')]),
    Wrong(what='A name is misspelled.',
          says='param is not known. Is params meant?',
          edits=[(DRAW, DRAW.replace('params', 'param'))],
          place='Line'),
    Wrong(what='It sleeps in the callback to keep a rate.',
          says='camera_callback sleeps, so it is slower than the camera, and frames get lost or come late.'
               ' Leave it out: ROS calls it when there is a frame.',
          edits=[('        self.publisher.publish(result)',
                  '        self.publisher.publish(result)\n        rospy.Rate(1).sleep()')],
          place='Line'),
    Wrong(what='A color image is published as a gray one.',
          says='your image has three channels, but it is published as "mono8", and cv_bridge refuses that:'
               ' "bgr8".',
          edits=[("extract_centers(image), 'bgr8')", "extract_centers(image), 'mono8')")],
          place='Line'),
    Wrong(what='The node ends at once, since it does not spin.',
          says='the program ends at once, before the first frame comes: rospy.spin() at the end of main() '
               'lets it wait for frames.',
          edits=[('    rospy.spin()\n', '')],
          place=''),
    Wrong(what='The parameters are given to detectMarkers where corners would go, as the course writes it.',
          says='the third argument of cv2.aruco.detectMarkers is not the parameters. Name them: '
               'parameters=parameters.',
          edits=[('aruco.ArucoDetector(aruco_dict, parameters).detectMarkers(gray)',
                  'aruco.detectMarkers(gray, aruco_dict, parameters)')],
          place='Line'),
    Wrong(what='The mean over the wrong axis, so that a center has four numbers.',
          says='each of params has the shape (4,), but a point has (2,): its x and its y. quad[0].mean(axis=0) '
               'is the center of a tag, if quad is one of the corners that detectMarkers gives.',
          edits=[(APPEND, 'params.append(c.mean(axis=1))'),
                 ('    params = np.array(params)\n', ''), (DRAW, DRAW.replace('params', 'np.int32(params)'))],
          place='Line'),
    Wrong(what='An array is the key of a dict.',
          says='an array cannot be a key. Take the number in it, such as int(ids[i][0]).',
          edits=[('        c = corners[i][0]\n', '        c = corners[i][0]\n        {}[ids[i]] = c\n')],
          place='Line'),
    Wrong(what='The mean over the wrong axis, in an array of such points.',
          says='params has the shape (…, 4), but points have (…, 2): each its x and its y. Were means taken '
               'along the wrong axis? quad.mean(axis=0) is the center, if quad has the shape (4, 2).',
          edits=[(APPEND, 'params.append(c.mean(axis=1))'), (DRAW, DRAW.replace('params', 'np.int32(params)'))],
          place='Line'),
    Wrong(what='A line stands above the one that its value comes from.',
          says='c has no value here yet. It gets its first one further below, in line …: exchange the two.',
          edits=[('        c = corners[i][0]\n', ''), (APPEND, APPEND + '\n        c = corners[i][0]'),
                 (CIRCLE, '')],
          place='Line'),
]
