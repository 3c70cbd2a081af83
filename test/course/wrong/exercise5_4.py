"""What goes wrong when centers are put in order."""
from course.corpus import Wrong
from course.wrong import DRAWN_ON_WHOLE, HULL

APPEND = 'params.append((int(c[:, 0].mean()), int(c[:, 1].mean())))'
FIRST = '''    # the polygon through the centers, as they come
    cv2.drawContours(image, [params], -1, (255, 0, 150), -1)
'''
ORDER = 'params = order_coordinates(params)'
SECOND = '''    # the polygon through the centers, in order
    cv2.drawContours(image, [params], -1, (255, 0, 150), -1)
'''
# What the course draws below the ordered polygon is left out where it would be in the way.
ALONE = (FIRST, '')

WRONG = [
    Wrong(what='The centers are left as they come, as in exercise 5.3.',
          says='your polygon crosses itself. Its corners come in the order of the tags …. That is the '
               'order in which they were found.',
          edits=[('        %s\n' % ORDER, '        pass\n')]),
    Wrong(what='The ordered centers are not kept: params stays what it was.',
          says='your polygon crosses itself. Its corners come in the order of the tags …. That is the '
               'order in which they were found.',
          edits=[(ORDER, 'order_coordinates(params)')]),
    Wrong(what='The centers are ordered only if there are more than four.',
          says='your polygon crosses itself. Its corners come in the order of the tags …. That is the '
               'order in which they were found.',
          edits=[('len(params) >= 4', 'len(params) > 4')]),
    Wrong(what='The polygon is drawn only if there are more than four.',
          says='there are only points at the centers, and no polygon. Is one drawn, as a list of '
               'polygons ([points]), and on the image that you return? Are all four centers in it: is'
               ' append in the loop, or behind it?',
          edits=[ALONE, (SECOND, ''), ('len(params) >= 4', 'len(params) > 4'),
                 (ORDER, ORDER + '\n        cv2.drawContours(image, [params], -1, (255, 0, 150), -1)')]),
    Wrong(what='They are ordered by x alone.',
          says='your polygon crosses itself. Its corners come in the order of the tags …. That is '
               'column by column, as if sorted by x or by x + y alone. Four corners need two numbers,'
               ' such as x + y and y - x, or the angle around their middle, np.arctan2.',
          edits=[ALONE, (ORDER, 'params = params[np.argsort(params[:, 0])]')]),
    Wrong(what='They are ordered by their distance to the top left corner of the image.',
          says='your polygon crosses itself. Its corners come in the order of the tags …. That is '
               'column by column, as if sorted by x or by x + y alone. Four corners need two numbers,'
               ' such as x + y and y - x, or the angle around their middle, np.arctan2.',
          edits=[ALONE, (ORDER, 'params = np.array(sorted(params, key=np.linalg.norm))')]),
    Wrong(what='Row by row: top left, top right, bottom left, bottom right.',
          says='your polygon crosses itself. Its corners come in the order of the tags …. That is row by '
               'row: after the top right comes the bottom right.',
          edits=[ALONE, ('coordinates[2] = pts[np.argmax(s)]', 'coordinates[3] = pts[np.argmax(s)]'),
                 ('coordinates[3] = pts[np.argmax(diff)]', 'coordinates[2] = pts[np.argmax(diff)]')]),
    Wrong(what='They are ordered by the ids of their tags.',
          says='your polygon crosses itself. Its corners come in the order of the tags …. That is sorted '
               'by id, which says nothing of where a tag is.',
          edits=[ALONE, (ORDER, 'params = params[np.argsort(ids.ravel())]')]),
    Wrong(what='They are ordered by their angle, but as seen from the corner of the image.',
          says='your polygon crosses itself. Its corners come in the order of the tags ….',
          edits=[ALONE, (ORDER, 'params = params[np.argsort(np.arctan2(params[:, 1], params[:, 0]))]')]),
    Wrong(what='np.sort orders x and y each by itself, so that no center is left.',
          says='x and y were sorted each by itself, so they no longer belong together. Sort whole centers.',
          edits=[ALONE, (ORDER, 'params = np.sort(params, axis=0)')]),
    Wrong(what='A line is copied and not changed, so that one corner is there twice.',
          says='your polygon has only three corners, so one center is missing, or another is taken twice.',
          edits=[ALONE, ('coordinates[3] = pts[np.argmax(diff)]', 'coordinates[3] = pts[np.argmin(diff)]')]),
    Wrong(what='One of the four is never set, so that it is at 0, 0.',
          says='a corner of your polygon is (0, 0), the top left of the frame: it was never set.',
          edits=[ALONE, ('    coordinates[3] = pts[np.argmax(diff)]\n', '')]),
    Wrong(what='The coordinates are kept in bytes, which end at 255.',
          says='coordinates of more than 255 begin again at 0, since they are kept in np.uint8. Keep them '
               'in np.int32.',
          edits=[ALONE, ("dtype='int')", 'dtype=np.uint8)'),
                 (SECOND, SECOND.replace('[params]', '[np.int32(params)]'))]),
    Wrong(what='The coordinates are kept as fractions.',
          says='cv2.drawContours wants whole numbers, of int32, and params is of float64: [np.int32(params)].',
          edits=[("dtype='int')", 'dtype=float)')],
          place='Line'),
    Wrong(what='np.diff goes along the wrong axis.',
          says='there is no [4] here, only 4 of them. argmin and argmax count through all numbers of an '
               'array, row by row: is there one number for each point? np.diff(points, axis=1) and '
               'points.sum(axis=1) have one.',
          edits=[('np.diff(pts, axis=1)', 'np.diff(pts, axis=0)')],
          place='Line'),
    Wrong(what='The first corner of each tag instead of its center.',
          says="your polygon goes through the tags' first corners, not through their centers. A center is "
               'the mean of the four corners.',
          edits=[(APPEND, 'params.append((int(c[0][0]), int(c[0][1])))')]),
    Wrong(what='x and y are exchanged.',
          says='x and y are exchanged. Drawing functions take (x, y), while an array has the row, which is'
               ' y, first.',
          edits=[(APPEND, 'params.append((int(c[:, 1].mean()), int(c[:, 0].mean())))')]),
    Wrong(what='x and y are exchanged while ordering.',
          says='x and y are exchanged. Drawing functions take (x, y), while an array has the row, which is'
               ' y, first.',
          edits=[ALONE, ('return coordinates', 'return coordinates[:, ::-1].copy()')]),
    Wrong(what='Found in the small frame, drawn on the whole one.',
          says='your polygon is too near to the top left: the centers were found in a frame that was '
               'shrunk to 0.7, but drawn on the whole frame. Find and draw in the same image.',
          edits=DRAWN_ON_WHOLE),
    Wrong(what='An upright rectangle around the centers, which needs no order.',
          says='you draw an upright rectangle. Its corners should be the four centers.',
          edits=[ALONE, (SECOND, '''    x, y, wide, high = cv2.boundingRect(params)
    cv2.rectangle(image, (x, y), (x + wide, y + high), (255, 0, 150), -1)
''')]),
    Wrong(what='The least rectangle around the centers, which needs no order.',
          says='you draw a rectangle. A camera seldom sees one as such: the corners should be the four '
               'centers.',
          edits=[ALONE, (ORDER, 'params = cv2.boxPoints(cv2.minAreaRect(params)).astype(int)')]),
    Wrong(what='The hull of all corners of all tags, which needs no order.',
          says='your polygon goes around all tags, through their outermost corners, not through their '
               'centers. A center is the mean of the four corners.',
          edits=[ALONE, (SECOND, SECOND.replace('params', HULL))]),
    Wrong(what='The coordinates are returned instead of the image.',
          says='order_centers returned an array of the shape (4, 2), which looks like points or a matrix, '
               'not like an image.',
          edits=[('    return image', '    return params')]),
    Wrong(what='The polygon is not drawn.',
          says='there are only points at the centers, and no polygon. Is one drawn, as a list of '
               'polygons ([points]), and on the image that you return? Are all four centers in it: is'
               ' append in the loop, or behind it?',
          edits=[ALONE, (SECOND, '')]),
    Wrong(what='The polygon goes to a copy, and the frame is returned.',
          says='there are only points at the centers, and no polygon. Is one drawn, as a list of '
               'polygons ([points]), and on the image that you return? Are all four centers in it: is'
               ' append in the loop, or behind it?',
          edits=[ALONE, (SECOND, SECOND.replace('image,', 'image.copy(),'))]),
    Wrong(what='Each tag has its place by its id, and the ids are those of the wall at hand.',
          says='this dict has no key 2. Is it an id? A tag may have any, so count on none.',
          edits=[ALONE, (ORDER, '''places = dict(zip(ids.ravel().tolist(), params))
        params = np.array([places[1], places[2], places[3], places[4]])''')],
          place='Line'),
    Wrong(what='A try with a bare except hides that a name is misspelled.',
          says='there are only points at the centers, and no polygon. Is one drawn, as a list of '
               'polygons ([points]), and on the image that you return? Are all four centers in it: is'
               ' append in the loop, or behind it?',
          edits=[ALONE, (SECOND, '''    try:
        cv2.drawContours(image, [parms], -1, (255, 0, 150), -1)
    except:
        pass
''')]),
    Wrong(what='A list has no sum of its rows.',
          says='this is a list, and only an array has sum: np.array(…) makes one of it. (detectMarkers '
               'returns a tuple of arrays, one for each tag.)',
          edits=[('    params = np.array(params)\n', ''), ALONE],
          place='Line'),
    Wrong(what='The function has another name.',
          says='the function is called order_center, but it is judged by its name, which must be '
               'order_centers.',
          edits=[('def order_centers(', 'def order_center('),
                 ('(order_centers(image)', '(order_center(image)')],
          place='Line'),
    Wrong(what='The image is shown in a window from the callback.',
          says='cv2.imshow needs a screen. A robot has none, nor has every OpenCV windows: there the '
               'callback fails. Leave it out, and look at the topic with rqt_image_view.',
          edits=[('        self.publisher.publish(result)',
                  '''        self.publisher.publish(result)
        cv2.imshow('detection', image)
        cv2.waitKey(1)''')],
          place='Line'),
    Wrong(what='The callback never publishes.',
          says='nothing is published, so nobody sees what the function makes: publisher.publish(…) at the '
               'end of the callback.',
          edits=[('        self.publisher.publish(result)\n', '')],
          place=''),
    Wrong(what='It waits for the next image in a loop of its own, in the function.',
          says='order_centers did not come to its end within 5 seconds. Does a loop here never end, or '
               'does something wait? A function of one frame must not wait.',
          edits=[('    return image', '    while not rospy.is_shutdown():\n        pass\n    return image')],
          place='Line'),
    Wrong(what='The places that argmin gives are drawn, not the centers at these places.',
          says='places has 4 numbers in it, and no points. If they are places in the list of centers, as '
               'argmin gives them, take the centers there: centers[places].',
          edits=[('        params = order_coordinates(params)\n',
                  ('        s = params.sum(axis=1)\n        d = np.diff(params, axis=1)\n'
                  '        places = [np.argmin(s), np.argmin(d), np.argmax(s), np.argmax(d)]\n'
                  '        cv2.drawContours(image, [np.int32(places)], -1, (255, 0, 150), -1)\n'))],
          place='Line'),
    Wrong(what='One center alone is drawn: argmin where argsort is meant.',
          says='params is one point alone. A polygon is an array of all four, of shape (4, 2).',
          edits=[('        params = order_coordinates(params)\n',
                  '        params = np.float32(params)[np.argmin(params.sum(axis=1))]\n')],
          place='Line'),
    Wrong(what='Points are sorted as if they were numbers.',
          says='points cannot be compared, only numbers. Name the number that counts: key=lambda point: '
               'point[0], for example.',
          edits=[('params = order_coordinates(params)', 'params = sorted(params)')],
          place='Line'),
    Wrong(what='They are ordered by the angle around the corner of the image, not around their middle.',
          says='your polygon crosses itself. Its corners come in the order of the tags …. That is sorted by '
               'the angle around (0, 0). Take it around their middle, the mean of the four.',
          base='solution',
          edits=[(('ordered = centers[[np.argmin(total), np.argmin(difference), np.argmax(total), '
                  'np.argmax(difference)]]'),
                  'ordered = centers[np.argsort(np.arctan2(centers[:, 1], centers[:, 0]))]')]),
    Wrong(what='The places that argmin gives are made into points.',
          says='a polygon of a few pixels is drawn at the top left of the frame. Its points seem to be places '
               'in the list of centers, as argmin gives them: take the centers there, centers[np.argmin(…)].',
          edits=[('    cv2.drawContours(image, [params], -1, (255, 0, 150), -1)\n\n    if', '    if'),
                 ('        params = order_coordinates(params)\n',
                  ('        s = params.sum(axis=1)\n        d = np.diff(params, axis=1).ravel()\n'
                   '        params = np.array([[s.argmin(), d.argmin()], [s.argmax(), d.argmax()]])\n'))]),
]
