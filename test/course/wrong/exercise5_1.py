"""What goes wrong when tags are made."""
from course.corpus import Wrong

WRONG = [
    Wrong(what='The dictionary is asked for as in old versions of OpenCV.',
          says='OpenCV … has no Dictionary_get any more: it is '
               'cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250) now.',
          edits=[('aruco.getPredefinedDictionary', 'aruco.Dictionary_get')],
          place='Line'),
    Wrong(what='The tag is drawn as in old versions of OpenCV.',
          says='OpenCV … has no drawMarker any more: it is cv2.aruco.generateImageMarker(dictionary, '
               'tag_id, size) now.',
          edits=[('aruco.generateImageMarker', 'aruco.drawMarker')],
          place='Line'),
    Wrong(what='It counts from 0, so that the tags are 0 to 3.',
          says='The tags have the ids 0, 1, 2, 3: range(4) begins at 0. range(1, 5) is 1, 2, 3, 4, since '
               'the end does not count.',
          edits=[('range(1, 5)', 'range(4)')],
          place=''),
    Wrong(what='range(1, 4) ends with 3.',
          says='Tag 4 is missing: range(1, 4) ends before 4. range(1, 5) is 1, 2, 3, 4.',
          edits=[('range(1, 5)', 'range(1, 4)')],
          place=''),
    Wrong(what='The files count from 1, the tags from 0.',
          says='The tags have the ids 0, 1, 2, 3: range(4) begins at 0. range(1, 5) is 1, 2, 3, 4, since '
               'the end does not count.',
          edits=[('draw_tag(i, size)', 'draw_tag(i - 1, size)')],
          place=''),
    Wrong(what='The dictionary is of tags with 4x4 cells.',
          says='It shows a tag of DICT_4X4, but the tags are to be of DICT_6X6_250: a camera that looks '
               'for those does not find it.',
          edits=[('aruco.DICT_6X6_250', 'aruco.DICT_4X4_50')],
          place='Tags'),
    Wrong(what='The dictionary is of tags with 5x5 cells.',
          says='It shows a tag of DICT_5X5, but the tags are to be of DICT_6X6_250: a camera that looks '
               'for those does not find it.',
          edits=[('aruco.DICT_6X6_250', 'aruco.DICT_5X5_250')],
          place='Tags'),
    Wrong(what='All files have the same tag.',
          says='All files show tag 1. Draw each with an id of its own: 1, 2, 3, 4.',
          edits=[('draw_tag(i, size)', 'draw_tag(1, size)')],
          place=''),
    Wrong(what='Files are written to wherever the program is started.',
          says='Your program writes image_4.jpg into the folder that it is started from, which may be any.'
               ' Write the files into the folder Tags of your package, which is …/Tags.',
          edits=[("FOLDER + '/image_'", "'image_'")],
          place=''),
    Wrong(what="The path is that of the course's own machine, where there is no such folder.",
          says="/home/user/catkin_ws/src/unit5/Tags/image_1.jpg was not written: cv2.imwrite only "
               "returns False then. There is no folder /home/user/catkin_ws/src/unit5/Tags. The "
               "folder for it is TAGS: os.path.join(TAGS, 'image_1.jpg').",
          edits=[("FOLDER + '/image_'", "'/home/user/catkin_ws/src/unit5/Tags/image_'")],
          place=''),
    Wrong(what='A path with ~, which only a shell knows.',
          says='~/catkin_ws/src/my_unit5/Tags/image_1.jpg was not written: cv2.imwrite only returns False '
               'then. Only a shell knows what ~ is: os.path.expanduser(path) replaces it.',
          edits=[("FOLDER + '/image_'", "'~/catkin_ws/src/my_unit5/Tags/image_'")],
          place=''),
    Wrong(what='The number is left out of the file name, so that each tag overwrites the one before.',
          says='There is only one file, Tags/image_i.jpg, with tag 4. If all four tags are written to one '
               'name, each replaces the one before: put the id into the name.',
          edits=[("'/image_' + str(i) + '.jpg'", "'/image_i.jpg'")],
          place=''),
    Wrong(what='A number is added to a text.',
          says='a text and a number cannot be added. str(…) makes a text of a number.',
          edits=[('str(i)', 'i')],
          place='Line'),
    Wrong(what='Black and white are exchanged.',
          says='Black and white are exchanged: the border of a tag is black, and the paper around it white.',
          edits=[('return aruco.generateImageMarker(aruco_dict, tag_id, size)',
                  'return 255 - aruco.generateImageMarker(aruco_dict, tag_id, size)')],
          place='Tags'),
    Wrong(what='The tag is mirrored.',
          says='The tag is mirrored.',
          edits=[('return aruco.generateImageMarker(aruco_dict, tag_id, size)',
                  'return cv2.flip(aruco.generateImageMarker(aruco_dict, tag_id, size), 1)')],
          place='Tags'),
    Wrong(what='The tag is not returned.',
          says='cv2.imwrite got no image to write: it is None, or empty. Does the function that made it '
               'return it?',
          edits=[('return aruco.generateImageMarker', 'img = aruco.generateImageMarker')],
          place='Line'),
    Wrong(what='Id and size are exchanged.',
          says='the tag would be smaller than its cells. The order is (dictionary, id, size): are id and '
               'size exchanged?',
          edits=[('aruco_dict, tag_id, size)', 'aruco_dict, size, tag_id)')],
          place='Line'),
    Wrong(what='It is shown in a window, and waits for a key.',
          says='cv2.imshow needs a window on a screen, which a robot does not have, nor the OpenCV '
               'that comes with pip. Leave it out. The same goes for waitKey in line ….',
          edits=[("'.jpg', img)", "'.jpg', img)\n        cv2.imshow('artag', img)\n        cv2.waitKey(0)")],
          place='Line'),
    Wrong(what='The program is never started.',
          says='nothing calls main(), so the program does nothing. At the end of the file belong "if '
               '__name__ == \'__main__\':" and, indented below it, "main()".',
          edits=[("\n\nif __name__ == '__main__':\n    main()\n", '')],
          place='Line'),
    Wrong(what='The name of the program is compared with the wrong word.',
          says='__name__ is "__main__" in a program that runs, with two underscores on each side, and '
               'never "main".',
          edits=[("'__main__'", "'main'")],
          place='Line'),
    Wrong(what='The folder is made again, though it is there.',
          says='…/Tags is there already. os.makedirs(…, exist_ok=True) does not mind that.',
          edits=[('    os.makedirs(', '    os.mkdir(FOLDER)\n    os.makedirs(')],
          place='Line'),
    Wrong(what='The tag fills only a part of its image: it is drawn onto a black square.',
          says='No tag of DICT_6X6_250 is seen in it, not even on white paper.',
          body='''
def draw_tag(tag_id, size):
    img = np.zeros((size, size), np.uint8)
    small = aruco.generateImageMarker(aruco.getPredefinedDictionary(aruco.DICT_6X6_250), tag_id, size // 2)
    img[:size // 2, :size // 2] = small
    return img
''', edits=[('import cv2\n', 'import cv2\nimport numpy as np\n')], place='Tags'),
    Wrong(what='A colon is forgotten.',
          says='a colon (:) is missing at the end of this line.',
          edits=[('range(1, 5):', 'range(1, 5)')],
          place='Line'),
]
