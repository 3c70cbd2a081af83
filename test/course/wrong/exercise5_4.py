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
          says='crosses itself',
          edits=[('        %s\n' % ORDER, '        pass\n')]),
    Wrong(what='The ordered centers are not kept: params stays what it was.',
          says='crosses itself',
          edits=[(ORDER, 'order_coordinates(params)')]),
    Wrong(what='The centers are ordered only if there are more than four.',
          says='crosses itself',
          edits=[('len(params) >= 4', 'len(params) > 4')]),
    Wrong(what='The polygon is drawn only if there are more than four.',
          says='polygon',
          edits=[ALONE, (SECOND, ''), ('len(params) >= 4', 'len(params) > 4'),
                 (ORDER, ORDER + '\n        cv2.drawContours(image, [params], -1, (255, 0, 150), -1)')]),
    Wrong(what='They are ordered by x alone.',
          says='crosses itself',
          edits=[ALONE, (ORDER, 'params = params[np.argsort(params[:, 0])]')]),
    Wrong(what='They are ordered by their distance to the top left corner of the image.',
          says='crosses itself',
          edits=[ALONE, (ORDER, 'params = np.array(sorted(params, key=np.linalg.norm))')]),
    Wrong(what='Row by row: top left, top right, bottom left, bottom right.',
          says='crosses itself',
          edits=[ALONE, ('coordinates[2] = pts[np.argmax(s)]', 'coordinates[3] = pts[np.argmax(s)]'),
                 ('coordinates[3] = pts[np.argmax(diff)]', 'coordinates[2] = pts[np.argmax(diff)]')]),
    Wrong(what='They are ordered by the ids of their tags.',
          says='crosses itself',
          edits=[ALONE, (ORDER, 'params = params[np.argsort(ids.ravel())]')]),
    Wrong(what='They are ordered by their angle, but as seen from the corner of the image.',
          says='crosses itself',
          edits=[ALONE, (ORDER, 'params = params[np.argsort(np.arctan2(params[:, 1], params[:, 0]))]')]),
    Wrong(what='np.sort orders x and y each by itself, so that no center is left.',
          says='np.sort',
          edits=[ALONE, (ORDER, 'params = np.sort(params, axis=0)')]),
    Wrong(what='A line is copied and not changed, so that one corner is there twice.',
          says='twice',
          edits=[ALONE, ('coordinates[3] = pts[np.argmax(diff)]', 'coordinates[3] = pts[np.argmin(diff)]')]),
    Wrong(what='One of the four is never set, so that it is at 0, 0.',
          says='0, 0',
          edits=[ALONE, ('    coordinates[3] = pts[np.argmax(diff)]\n', '')]),
    Wrong(what='The coordinates are kept in bytes, which end at 255.',
          says='255',
          edits=[ALONE, ("dtype='int')", 'dtype=np.uint8)'),
                 (SECOND, SECOND.replace('[params]', '[np.int32(params)]'))]),
    Wrong(what='The coordinates are kept as fractions.',
          says='int32',
          edits=[("dtype='int')", 'dtype=float)')],
          place='Line'),
    Wrong(what='np.diff goes along the wrong axis.',
          says='axis',
          edits=[('np.diff(pts, axis=1)', 'np.diff(pts, axis=0)')]),
    Wrong(what='The first corner of each tag instead of its center.',
          says='first corner',
          edits=[(APPEND, 'params.append((int(c[0][0]), int(c[0][1])))')]),
    Wrong(what='x and y are exchanged.',
          says='x and y',
          edits=[(APPEND, 'params.append((int(c[:, 1].mean()), int(c[:, 0].mean())))')]),
    Wrong(what='x and y are exchanged while ordering.',
          says='x and y',
          edits=[ALONE, ('return coordinates', 'return coordinates[:, ::-1].copy()')]),
    Wrong(what='Found in the small frame, drawn on the whole one.',
          says='0.7',
          edits=DRAWN_ON_WHOLE),
    Wrong(what='An upright rectangle around the centers, which needs no order.',
          says='upright rectangle',
          edits=[ALONE, (SECOND, '''    x, y, wide, high = cv2.boundingRect(params)
    cv2.rectangle(image, (x, y), (x + wide, y + high), (255, 0, 150), -1)
''')]),
    Wrong(what='The least rectangle around the centers, which needs no order.',
          says='rectangle',
          edits=[ALONE, (ORDER, 'params = cv2.boxPoints(cv2.minAreaRect(params)).astype(int)')]),
    Wrong(what='The hull of all corners of all tags, which needs no order.',
          says='corner',
          edits=[ALONE, (SECOND, SECOND.replace('params', HULL))]),
    Wrong(what='The coordinates are returned instead of the image.',
          says='image',
          edits=[('    return image', '    return params')]),
    Wrong(what='The polygon is not drawn.',
          says='polygon',
          edits=[ALONE, (SECOND, '')]),
    Wrong(what='The polygon goes to a copy, and the frame is returned.',
          says='polygon',
          edits=[ALONE, (SECOND, SECOND.replace('image,', 'image.copy(),'))]),
    Wrong(what='Each tag has its place by its id, and the ids are those of the wall at hand.',
          says='id',
          edits=[ALONE, (ORDER, '''places = dict(zip(ids.ravel().tolist(), params))
        params = np.array([places[1], places[2], places[3], places[4]])''')],
          place='Line'),
    Wrong(what='A try with a bare except hides that a name is misspelled.',
          says='except',
          edits=[ALONE, (SECOND, '''    try:
        cv2.drawContours(image, [parms], -1, (255, 0, 150), -1)
    except:
        pass
''')]),
    Wrong(what='A list has no sum of its rows.',
          says='np.array',
          edits=[('    params = np.array(params)\n', ''), ALONE],
          place='Line'),
    Wrong(what='The function has another name.',
          says='order_centers',
          edits=[('def order_centers(', 'def order_center('),
                 ('(order_centers(image)', '(order_center(image)')],
          place=''),
    Wrong(what='The image is shown in a window from the callback.',
          says='imshow',
          edits=[('        self.publisher.publish(result)',
                  '''        self.publisher.publish(result)
        cv2.imshow('detection', image)
        cv2.waitKey(1)''')],
          place='Line'),
    Wrong(what='The callback never publishes.',
          says='publish',
          edits=[('        self.publisher.publish(result)\n', '')],
          place='Line'),
    Wrong(what='It waits for the next image in a loop of its own, in the function.',
          says='Line',
          edits=[('    return image', '    while not rospy.is_shutdown():\n        pass\n    return image')],
          place='Line'),
]
