"""What goes wrong when tags are looked for."""
from course.corpus import Wrong
from course.wrong import DRAWN_ON_WHOLE, SHRINK

DRAW = 'frame_markers = aruco.drawDetectedMarkers(image.copy(), corners, ids)'
FIND = 'corners, ids, rejected = aruco.ArucoDetector(aruco_dict, parameters).detectMarkers(gray)'
NUMPY = ('import rospy\n', 'import numpy as np\nimport rospy\n')

WRONG = [
    Wrong(what='The dictionary is asked for as in old versions of OpenCV.',
          says='getPredefinedDictionary',
          edits=[('aruco.getPredefinedDictionary', 'aruco.Dictionary_get')],
          place='Line'),
    Wrong(what='The parameters are asked for as in old versions of OpenCV.',
          says='DetectorParameters()',
          edits=[('aruco.DetectorParameters()', 'aruco.DetectorParameters_create()')],
          place='Line'),
    Wrong(what='The detector is called without making one.',
          says='ArucoDetector(',
          edits=[('aruco.ArucoDetector(aruco_dict, parameters).detectMarkers(gray)',
                  'aruco.ArucoDetector.detectMarkers(gray)')],
          place='Line'),
    Wrong(what='The dictionary is of tags with 4x4 cells, so none is found.',
          says='dictionary',
          edits=[('aruco.DICT_6X6_250', 'aruco.DICT_4X4_50')]),
    Wrong(what='The drawing goes to a copy, and the frame is returned.',
          says='as it came',
          edits=[('return frame_markers', 'return image')]),
    Wrong(what='What is found is not drawn: the small frame is returned.',
          says='as it came',
          edits=[(DRAW, 'frame_markers = image')]),
    Wrong(what='Outlines without ids.',
          says='id',
          edits=[(DRAW, 'frame_markers = aruco.drawDetectedMarkers(image.copy(), corners)')]),
    Wrong(what='Ids without outlines.',
          says='outline',
          edits=[NUMPY, (DRAW, '''frame_markers = image
    for c, number in zip(corners, ids.ravel()):
        cv2.putText(image, str(number), np.int32(c[0].mean(axis=0)).tolist(), 0, 0.6, 255, 2)''')]),
    Wrong(what='A dot in the center of each tag, and no outline.',
          says='outline',
          edits=[NUMPY, (DRAW, '''frame_markers = image
    for c in corners:
        cv2.circle(image, np.int32(c[0].mean(axis=0)).tolist(), 5, (0, 0, 255), -1)''')]),
    Wrong(what="The tag's place in the list is written, not its id.",
          says='place in the list',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        cv2.polylines(image, [corners[i].astype(int)], True, 255, 2)
        x, y = corners[i][0].mean(axis=0)
        cv2.putText(image, str(i), (int(x), int(y)), 0, 0.6, 255, 2)''')]),
    Wrong(what='The id of the first tag is written into all of them.',
          says='same',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        cv2.polylines(image, [corners[i].astype(int)], True, 255, 2)
        x, y = corners[i][0].mean(axis=0)
        cv2.putText(image, str(ids[0][0]), (int(x), int(y)), 0, 0.6, 255, 2)''')]),
    Wrong(what='All ids are written at the first tag.',
          says='id',
          edits=[(DRAW, '''frame_markers = aruco.drawDetectedMarkers(image.copy(), corners)
    x, y = corners[0][0].mean(axis=0)
    cv2.putText(frame_markers, str(ids.ravel()), (int(x), int(y)), 0, 0.6, 255, 2)''')]),
    Wrong(what='The ids are reversed, so each tag has that of another.',
          says='id',
          edits=[(DRAW, 'frame_markers = aruco.drawDetectedMarkers(image.copy(), corners, ids[::-1].copy())')]),
    Wrong(what='Only the first tag is drawn.',
          says='one',
          edits=[(DRAW, 'frame_markers = aruco.drawDetectedMarkers(image.copy(), corners[:1], ids[:1])')]),
    Wrong(what='return stands in the loop, so it ends with the first tag.',
          says='one',
          edits=[(DRAW, '''for i in range(len(ids)):
        frame_markers = image
        cv2.polylines(image, [corners[i].astype(int)], True, 255, 2)
        x, y = corners[i][0].mean(axis=0)
        cv2.putText(image, str(ids[i][0]), (int(x), int(y)), 0, 0.6, 255, 2)
        return image''')]),
    Wrong(what='The last tag is left out: range(len(ids) - 1).',
          says='one',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids) - 1):
        aruco.drawDetectedMarkers(image, corners[i:i + 1], ids[i:i + 1])''')]),
    Wrong(what='Upright rectangles around the tags.',
          says='upright',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        x, y, wide, high = cv2.boundingRect(corners[i])
        cv2.rectangle(image, (x, y), (x + wide, y + high), 255, 2)
        cv2.putText(image, str(ids[i][0]), (x + 5, y + 20), 0, 0.6, 255, 2)''')]),
    Wrong(what='Outlines that are not closed.',
          says='side',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        cv2.polylines(image, [corners[i].astype(int)], False, 255, 2)
        x, y = corners[i][0].mean(axis=0)
        cv2.putText(image, str(ids[i][0]), (int(x), int(y)), 0, 0.6, 255, 2)''')]),
    Wrong(what='Corners as fractions of a pixel, where OpenCV wants whole numbers.',
          says='int',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        cv2.polylines(image, [corners[i]], True, 255, 2)''')],
          place='Line'),
    Wrong(what='The place of the id as fractions of a pixel.',
          says='int',
          edits=[(DRAW, '''frame_markers = aruco.drawDetectedMarkers(image, corners)
    for i in range(len(ids)):
        cv2.putText(image, str(ids[i][0]), tuple(corners[i][0][0]), 0, 0.6, 255, 2)''')],
          place='Line'),
    Wrong(what='x and y are exchanged.',
          says='x and y',
          edits=[(DRAW, '''frame_markers = image
    aruco.drawDetectedMarkers(image, [c[:, :, ::-1].copy() for c in corners], ids)''')]),
    Wrong(what='Found in the whole frame, drawn on the small one.',
          says='0.7',
          edits=[(SHRINK, ''),
                 (DRAW, '''image = cv2.resize(image, (int(w * 0.7), int(h * 0.7)))
    frame_markers = aruco.drawDetectedMarkers(image.copy(), corners, ids)''')]),
    Wrong(what='Found in the small frame, drawn on the whole one.',
          says='0.7',
          edits=DRAWN_ON_WHOLE),
    Wrong(what='The results of the detector are taken in a wrong order.',
          says='corners, ids',
          edits=[('corners, ids, rejected =', 'ids, corners, rejected =')],
          place='Line'),
    Wrong(what='What the detector rejected is drawn.',
          says='reject',
          edits=[(DRAW, 'frame_markers = aruco.drawDetectedMarkers(image.copy(), rejected)')]),
    Wrong(what='Nothing is returned.',
          says='return',
          edits=[('    return frame_markers\n', '')],
          place=''),
    Wrong(what='It is shown in a window, as in the course, and nothing is returned.',
          says='imshow',
          edits=[('return frame_markers', "cv2.imshow('markers', frame_markers)\n    cv2.waitKey(1)")],
          place='Line'),
    Wrong(what='The gray image is turned to gray again.',
          says='gray',
          edits=[(FIND, FIND.replace('gray)', 'cv2.cvtColor(gray, cv2.COLOR_BGR2GRAY))'))],
          place='Line'),
    Wrong(what='A publisher is made for each frame.',
          says='publisher',
          edits=[("        self.publisher = rospy.Publisher('~image', Image, queue_size=1)\n", ''),
                 ('        self.publisher.publish(result)',
                  '''        self.publisher = rospy.Publisher('~image', Image, queue_size=1)
        self.publisher.publish(result)''')],
          place='Line'),
    Wrong(what='The file is not executable, so rosrun does not find it.',
          says='chmod +x',
          executable=False, place=''),
]
