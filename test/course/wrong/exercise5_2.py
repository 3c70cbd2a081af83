"""What goes wrong when tags are looked for."""
from course.corpus import Wrong
from course.wrong import DRAWN_ON_WHOLE, SHRINK

DRAW = 'frame_markers = aruco.drawDetectedMarkers(image.copy(), corners, ids)'
FIND = 'corners, ids, rejected = aruco.ArucoDetector(aruco_dict, parameters).detectMarkers(gray)'
NUMPY = ('import rospy\n', 'import numpy as np\nimport rospy\n')

WRONG = [
    Wrong(what='The dictionary is asked for as in old versions of OpenCV.',
          says='OpenCV … has no Dictionary_get any more: it is '
               'cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250) now.',
          edits=[('aruco.getPredefinedDictionary', 'aruco.Dictionary_get')],
          place='Line'),
    Wrong(what='The parameters are asked for as in old versions of OpenCV.',
          says='OpenCV … has no DetectorParameters_create any more: it is cv2.aruco.DetectorParameters() now.',
          edits=[('aruco.DetectorParameters()', 'aruco.DetectorParameters_create()')],
          place='Line'),
    Wrong(what='The detector is called without making one.',
          says='detectMarkers belongs to ArucoDetector, of which one is made first: '
               'ArucoDetector(…).detectMarkers(…).',
          edits=[('aruco.ArucoDetector(aruco_dict, parameters).detectMarkers(gray)',
                  'aruco.ArucoDetector.detectMarkers(gray)')],
          place='Line'),
    Wrong(what='The dictionary is of tags with 4x4 cells, so none is found.',
          says='nothing is drawn: your image is the frame as it came. Were the tags found (dictionary '
               'DICT_6X6_250)? Do you return the image on which you draw?',
          edits=[('aruco.DICT_6X6_250', 'aruco.DICT_4X4_50')]),
    Wrong(what='The drawing goes to a copy, and the frame is returned.',
          says='nothing is drawn: your image is the frame as it came. Were the tags found (dictionary '
               'DICT_6X6_250)? Do you return the image on which you draw?',
          edits=[('return frame_markers', 'return image')]),
    Wrong(what='What is found is not drawn: the small frame is returned.',
          says='nothing is drawn: your image is the frame as it came. Were the tags found (dictionary '
               'DICT_6X6_250)? Do you return the image on which you draw?',
          edits=[(DRAW, 'frame_markers = image')]),
    Wrong(what='Outlines without ids.',
          says='the tags are outlined, but their ids are not written.',
          edits=[(DRAW, 'frame_markers = aruco.drawDetectedMarkers(image.copy(), corners)')]),
    Wrong(what='Ids without outlines.',
          says='the tags are not outlined, though something is drawn there. Draw lines from each '
               'corner of a tag to the next. The corners are the first of what detectMarkers returns.',
          edits=[NUMPY, (DRAW, '''frame_markers = image
    for c, number in zip(corners, ids.ravel()):
        cv2.putText(image, str(number), np.int32(c[0].mean(axis=0)).tolist(), 0, 0.6, 255, 2)''')]),
    Wrong(what='A dot in the center of each tag, and no outline.',
          says='the tags are not outlined, though something is drawn there. Draw lines from each '
               'corner of a tag to the next. The corners are the first of what detectMarkers returns.',
          edits=[NUMPY, (DRAW, '''frame_markers = image
    for c in corners:
        cv2.circle(image, np.int32(c[0].mean(axis=0)).tolist(), 5, (0, 0, 255), -1)''')]),
    Wrong(what="The tag's place in the list is written, not its id.",
          says='the same is written for the ids …. Write the id of each tag at it, not its position in the'
               ' list, nor the id of another.',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        cv2.polylines(image, [corners[i].astype(int)], True, 255, 2)
        x, y = corners[i][0].mean(axis=0)
        cv2.putText(image, str(i), (int(x), int(y)), 0, 0.6, 255, 2)''')]),
    Wrong(what='The id of the first tag is written into all of them.',
          says='the same is written for the ids …. Write the id of each tag at it, not its position in the'
               ' list, nor the id of another.',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        cv2.polylines(image, [corners[i].astype(int)], True, 255, 2)
        x, y = corners[i][0].mean(axis=0)
        cv2.putText(image, str(ids[0][0]), (int(x), int(y)), 0, 0.6, 255, 2)''')]),
    Wrong(what='All ids are written at the first tag.',
          says='the id … is written at tag …. Take the corners and the id from the same position of their '
               'lists.',
          edits=[(DRAW, '''frame_markers = aruco.drawDetectedMarkers(image.copy(), corners)
    x, y = corners[0][0].mean(axis=0)
    cv2.putText(frame_markers, str(ids.ravel()), (int(x), int(y)), 0, 0.6, 255, 2)''')]),
    Wrong(what='The ids are reversed, so each tag has that of another.',
          says='the id … is written at tag …. Take the corners and the id from the same position of their '
               'lists.',
          edits=[(DRAW, 'frame_markers = aruco.drawDetectedMarkers(image.copy(), corners, ids[::-1].copy())')]),
    Wrong(what='Only the first tag is drawn.',
          says='only one tag is outlined, not …. Draw in a loop over all of them, and return behind '
               'it.',
          edits=[(DRAW, 'frame_markers = aruco.drawDetectedMarkers(image.copy(), corners[:1], ids[:1])')]),
    Wrong(what='return stands in the loop, so it ends with the first tag.',
          says='only one tag is outlined, not …. Draw in a loop over all of them, and return behind '
               'it.',
          edits=[(DRAW, '''for i in range(len(ids)):
        frame_markers = image
        cv2.polylines(image, [corners[i].astype(int)], True, 255, 2)
        x, y = corners[i][0].mean(axis=0)
        cv2.putText(image, str(ids[i][0]), (int(x), int(y)), 0, 0.6, 255, 2)
        return image''')]),
    Wrong(what='The last tag is left out: range(len(ids) - 1).',
          says='tag … is not outlined.',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids) - 1):
        aruco.drawDetectedMarkers(image, corners[i:i + 1], ids[i:i + 1])''')]),
    Wrong(what='Upright rectangles around the tags.',
          says='you draw upright rectangles around the tags. Draw the lines through their four corners.',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        x, y, wide, high = cv2.boundingRect(corners[i])
        cv2.rectangle(image, (x, y), (x + wide, y + high), 255, 2)
        cv2.putText(image, str(ids[i][0]), (x + 5, y + 20), 0, 0.6, 255, 2)''')]),
    Wrong(what='Outlines that are not closed.',
          says='the outlines are not closed: the line from the last corner to the first is missing.',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        cv2.polylines(image, [corners[i].astype(int)], False, 255, 2)
        x, y = corners[i][0].mean(axis=0)
        cv2.putText(image, str(ids[i][0]), (int(x), int(y)), 0, 0.6, 255, 2)''')]),
    Wrong(what='Corners as fractions of a pixel, where OpenCV wants whole numbers.',
          says='the points that cv2.polylines draws must be whole numbers of 32 bits, a list of arrays: '
               '[np.int32(points)].',
          edits=[(DRAW, '''frame_markers = image
    for i in range(len(ids)):
        cv2.polylines(image, [corners[i]], True, 255, 2)''')],
          place='Line'),
    Wrong(what='The place of the id as fractions of a pixel.',
          says='a point must be a tuple of two whole numbers: (int(x), int(y)).',
          edits=[(DRAW, '''frame_markers = aruco.drawDetectedMarkers(image, corners)
    for i in range(len(ids)):
        cv2.putText(image, str(ids[i][0]), tuple(corners[i][0][0]), 0, 0.6, 255, 2)''')],
          place='Line'),
    Wrong(what='x and y are exchanged.',
          says='x and y are exchanged. Drawing functions take (x, y), while an array has the row, which is'
               ' y, first.',
          edits=[(DRAW, '''frame_markers = image
    aruco.drawDetectedMarkers(image, [c[:, :, ::-1].copy() for c in corners], ids)''')]),
    Wrong(what='Found in the whole frame, drawn on the small one.',
          says='the outlines are too far to the right and too low: the tags were found in the whole frame,'
               ' but drawn on one that was shrunk to 0.7. Find and draw in the same image.',
          edits=[(SHRINK, ''),
                 (DRAW, '''image = cv2.resize(image, (int(w * 0.7), int(h * 0.7)))
    frame_markers = aruco.drawDetectedMarkers(image.copy(), corners, ids)''')]),
    Wrong(what='Found in the small frame, drawn on the whole one.',
          says='the outlines are too near to the top left: the tags were found in a frame that was shrunk '
               'to 0.7, but drawn on the whole frame. Find and draw in the same image.',
          edits=DRAWN_ON_WHOLE),
    Wrong(what='The results of the detector are taken in a wrong order.',
          says='what is called ids here is a list of corners. detectMarkers returns three things, in the '
               'order corners, ids, rejected.',
          edits=[('corners, ids, rejected =', 'ids, corners, rejected =')],
          place='Line'),
    Wrong(what='What the detector rejected is drawn.',
          says='squares are outlined that the detector rejected. It returns corners, ids and rejected '
               'candidates, in this order; draw the first.',
          edits=[(DRAW, 'frame_markers = aruco.drawDetectedMarkers(image.copy(), rejected)')]),
    Wrong(what='Nothing is returned.',
          says='detect_tags returns nothing: it lacks the line "return image" at its end, with the '
               'names that the result has in your code.',
          edits=[('    return frame_markers\n', '')],
          place='Line'),
    Wrong(what='It is shown in a window, as in the course, and nothing is returned.',
          says='cv2.imshow needs a window on a screen, which a robot does not have, nor the OpenCV '
               'that comes with pip. Leave it out, and return frame_markers. The same goes for waitKey '
               'in line ….',
          edits=[('return frame_markers', "cv2.imshow('markers', frame_markers)\n    cv2.waitKey(1)")],
          place='Line'),
    Wrong(what='The gray image is turned to gray again.',
          says='cv2.cvtColor gets an image with a number of channels that does not fit: is it gray '
               'already, or is it colored where a gray one is needed?',
          edits=[(FIND, FIND.replace('gray)', 'cv2.cvtColor(gray, cv2.COLOR_BGR2GRAY))'))],
          place='Line'),
    Wrong(what='A publisher is made for each frame.',
          says='a publisher is made for each frame, in camera_callback. A new one has no listeners yet, so'
               ' its messages are lost: make it once, in main(), before the subscriber.',
          edits=[("        self.publisher = rospy.Publisher('~image', Image, queue_size=1)\n", ''),
                 ('        self.publisher.publish(result)',
                  '''        self.publisher = rospy.Publisher('~image', Image, queue_size=1)
        self.publisher.publish(result)''')],
          place='Line'),
    Wrong(what='The file is not executable, so rosrun does not find it.',
          says='the function is right, but rosrun does not find the file, since it is not executable: '
               '"chmod +x exercise5_2.py".',
          executable=False, place=''),
    Wrong(what='The frame is read from a file of the course, instead of the one that comes.',
          says='image is given to the function, and this line puts an image of a file in its place. Leave the '
               'line out.',
          edits=[(SHRINK, "    image = cv2.imread('/home/user/catkin_ws/src/unit5/image.png')\n" + SHRINK)],
          place='Line'),
    Wrong(what='The id as a number, where a text is to be written.',
          says='cv2.putText writes a text, and a number is none: str(number) makes one of it.',
          edits=[(DRAW, 'frame_markers = cv2.putText(image, ids[0], (9, 30), 0, 1, (0, 255, 0))')],
          place='Line'),
    Wrong(what='The parameters come first, and the dictionary second.',
          says='… wants the dictionary first. Are arguments exchanged? It is '
               'generateImageMarker(dictionary, id, size), and ArucoDetector(dictionary, parameters).',
          edits=[('ArucoDetector(aruco_dict, parameters)', 'ArucoDetector(parameters, aruco_dict)')],
          place='Line'),
    Wrong(what='All ids are written at each tag.',
          says='all ids are written at each tag, or several of them. At each belongs its own alone: '
               'str(ids[i][0]).',
          edits=[(DRAW, '''frame_markers = image.copy()
    for quad in corners:
        points = quad[0].astype(int)
        cv2.polylines(frame_markers, [points], True, (0, 255, 0), 2)
        cv2.putText(frame_markers, str(ids.ravel()), tuple(points[0].tolist()), 0, 0.5, (0, 0, 255), 2)''')]),
    Wrong(what='Corners as uint8, which ends at 255.',
          says='the outlines of tags on the right, or below, are elsewhere: their corners are numbers beyond '
               '255, where uint8 ends. Use int32.',
          edits=[(DRAW, '''frame_markers = image.copy()
    for quad in corners:
        points = quad[0].astype(int).astype('uint8').astype(int)
        cv2.polylines(frame_markers, [points], True, (0, 255, 0), 2)''')]),
    Wrong(what='The lines are pasted at the left margin, below the function.',
          says='this line does not belong to detect_tags, since it is not indented. Indent all lines of the '
               'function by four spaces. image is given to it, so it needs no value.',
          body='''
def detect_tags(image):
    return image


image = cv2.resize(image, None, fx=0.7, fy=0.7)
gray = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)''',
          place='Line'),
]
