"""What is wrong with a learner's file is told before it is run."""
import pytest
from aruco_course.exercises import CHECKS
from aruco_course.learner import package
from aruco_course.trial import fault_of_plumbing, fault_of_source

CHECK = {check.number: check for check in CHECKS}
NODE = package.solution(CHECK['5.4'])
FUNCTION = 'def order_centers(image):'


@pytest.fixture
def fault_of(tmp_path):
    """A function: the fault of our solution of exercise 5.4, some text replaced."""
    def find(find_fault, *edits, text=NODE):
        for old, new in edits:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / 'exercise5_4.py'
        path.write_bytes(text.encode('utf-8', 'surrogateescape'))
        path.chmod(0o755)
        return find_fault(str(path), CHECK['5.4'])
    return find


@pytest.mark.parametrize('number', list(CHECK))
def test_nothing_is_wrong_with_our_solutions(tmp_path, number):
    path = tmp_path / 'exercise.py'
    path.write_text(package.solution(CHECK[number]))
    path.chmod(0o755)
    assert fault_of_source(str(path), CHECK[number]) is None
    assert fault_of_plumbing(str(path), CHECK[number]) is None


@pytest.mark.parametrize('text, place, said', [
    ('', '', 'is empty'),
    (' \n\n', '', 'is empty'),
    ('def f(:\n    pass\n', 'Line 1', 'no Python'),
    ('x = 1\nif x\n    pass\n', 'Line 2', 'colon'),
    ('def f():\n# Task 1\n', 'Line', 'must be indented'),
    ('def f():\n    a = 1\n      b = 2\n', 'Line 3', 'indented'),
    ('def f():\n    if 1:\n        a = 1\n\tb = 2\n', 'Line 4', 'tabs and spaces'),
    ('x = (1,\ny = 2\n', 'Line', ''),
    ('print "x"\n', 'Line 1', 'Python 2'),
    ('x = 1\nreturn x\n', 'Line 2', 'outside'),
    ('x = "\udcff"\n', 'Line 1', 'UTF-8'),
    ('x = 1\ny = "a\n', 'Line 2', 'quotation mark'),
    ('x = 1\0\n', '', ''),
    ('x = ' + 2000 * '(' + ')' * 2000 + '\n', '', ''),
])
def test_what_is_no_python_is_told(fault_of, text, place, said):
    fault = fault_of(fault_of_source, text=text)
    assert fault.place.startswith(place)
    assert said in fault.what


def test_a_file_that_is_gone_is_told(tmp_path):
    assert 'reset' in fault_of_source(str(tmp_path / 'exercise5_4.py'), CHECK['5.4']).what


@pytest.mark.parametrize('edit, place, said', [
    ((FUNCTION, 'def order_center(image):'), 'Line', 'called order_center, but it is judged by its name'),
    ((FUNCTION, 'def orderCenters(image):'), 'Line', 'called orderCenters'),
    ((FUNCTION, 'def polygon(image):'), '', 'only polygon. It is judged by its name'),
    ((FUNCTION, 'def order_centers(image, corners):'), 'Line', 'takes 2 arguments, but it is called with 1'),
    ((FUNCTION, 'def order_centers():'), 'Line', 'takes no argument'),
    ((FUNCTION, 'def order_centers(self, image):'), 'Line', 'in no class'),
    ((FUNCTION, 'def order_centers(image, *, scale):'), 'Line', '2 arguments'),
    ((FUNCTION, 'class Orderer:\n  def order_centers(self, image):'), 'Line', 'inside the class Orderer'),
])
def test_a_function_that_is_not_as_it_should_be_is_told(fault_of, edit, place, said):
    fault = fault_of(fault_of_source, edit)
    assert bool(fault.place) == bool(place)
    assert said in fault.what


@pytest.mark.parametrize('text', [
    'class Node:\n    def __init__(self):\n        pass\n    def callback(self, message):\n        pass\n',
    'def image_callback(message):\n    pass\n\ndef main():\n    pass\n'])
def test_without_the_function_a_node_can_be_judged_as_it_is(fault_of, text):
    assert 'learn.py check 5.4 --node' in fault_of(fault_of_source, text=text).what


@pytest.mark.parametrize('definition', [
    'def order_centers(image, scale=0.7):', 'def order_centers(*images):\n    image = images[0]',
    'def order_centers(frame, /):\n    image = frame', 'if True:\n  def order_centers(image):'])
def test_other_functions_that_take_an_image_are_fine(fault_of, definition):
    assert fault_of(fault_of_source, (FUNCTION, definition)) is None


def test_lines_below_the_function_are_only_its_own_if_it_does_nothing(fault_of):
    paste = '    return image\n\n\nimage = cv2.imread("frame.png")\n'
    fault = fault_of(fault_of_source, text=FUNCTION + '\n' + paste)
    assert (fault.place, 'not indented' in fault.what) == ('Line 5', True)
    circle = '    cv2.circle(image, (9, 9), 3, 255)\n'
    assert fault_of(fault_of_source, text=FUNCTION + '\n' + circle + paste) is None


def test_a_function_from_elsewhere_is_fine(fault_of):
    assert fault_of(fault_of_source, text='from mine import order_centers\n') is None
    assert fault_of(fault_of_source, text='def f(image): return image\norder_centers = f\n') is None


SUBSCRIBER = ("    rospy.Subscriber('/camera/rgb/image_raw', Image, callback, queue_size=1, "
              'buff_size=2**24)\n')
CALLBACK = '    def callback(message):\n'
PUBLISHER = "    publisher = rospy.Publisher('~image', Image, queue_size=1)\n"


@pytest.mark.parametrize('edits, place, said', [
    ([('#!/usr/bin/env python3\n', '')], 'Line 1', '#!/usr/bin/env python3'),
    ([('#!/usr/bin/env python3', '#!/usr/bin/env python3.99')], 'Line 1', 'no python3.99 on this computer'),
    ([('#!/usr', '\ufeff#!/usr')], 'Line 1', 'BOM'),
    ([('\n', '\r\n')], 'Line 1', 'CRLF'),
    ([("if __name__ == '__main__':\n    main()\n", '')], 'Line', 'nothing calls main()'),
    ([("'__main__'", "'main'")], 'Line', 'two underscores'),
    ([('    main()\n', '    main\n')], 'Line', 'does not call main'),
    ([("    rospy.init_node('my_exercise5_4')\n", '')], '', 'rospy.init_node'),
    ([("'my_exercise5_4'", "'my-exercise5.4'")], 'Line', 'cannot have the name'),
    ([(CALLBACK, CALLBACK + PUBLISHER.replace('    pub', '        pub'))], 'Line', 'made for each frame'),
    ([(CALLBACK, CALLBACK + '        rospy.sleep(0.1)\n')], 'Line', 'sleeps'),
    ([('Image, callback,', 'Image, callback(None),')], 'Line', 'without the brackets'),
    ([(SUBSCRIBER, '')], '', 'nothing subscribes'),
    ([('        publisher.publish(result)\n', '')], '', 'nothing is published'),
    ([('(order_centers(image), ', '(image, ')], 'Line', 'nothing calls it'),
    ([('    rospy.spin()\n', '')], '', 'rospy.spin()'),
    ([("(message, 'bgr8')", "(message, 'bgr')")], 'Line', 'no encoding "bgr"'),
    ([("(message, 'bgr8')", "(message, 'rgb8')")], 'Line', 'red and blue'),
    ([("(message, 'bgr8')", '(message)')], 'Line', 'red and blue'),
    ([("(message, 'bgr8')", "(message, 'mono8')")], 'Line', 'gray frame'),
    ([(CALLBACK, CALLBACK + '        cv2.imshow("a", message)\n')], 'Line', 'imshow'),
])
def test_what_keeps_the_node_from_working_is_told(fault_of, edits, place, said):
    fault = fault_of(fault_of_plumbing, *edits)
    assert said in fault.what
    assert fault.place.startswith(place)
    assert bool(fault.place) == bool(place)


def test_a_file_that_is_not_executable_is_told(tmp_path):
    path = tmp_path / 'exercise5_4.py'
    path.write_text(NODE)
    path.chmod(0o644)
    assert 'chmod +x exercise5_4.py' in fault_of_plumbing(str(path), CHECK['5.4']).what


def test_a_file_without_any_node_is_told(fault_of):
    text = '#!/usr/bin/env python3\ndef order_centers(image):\n    return image\n'
    assert 'no node around it' in fault_of(fault_of_plumbing, text=text).what


@pytest.mark.parametrize('edits', [
    [('rospy.spin()', 'while not rospy.is_shutdown():\n        rospy.sleep(1)')],
    [("(message, 'bgr8')", "(message, desired_encoding='bgr8')")],
    [("(message, 'bgr8')", "(message, 'rgb8')"), ("(image), 'bgr8')", "(image), 'rgb8')")],
    [('Image, callback,', 'Image, callback=callback,')],
    [('    main()\n', '    try:\n        main()\n    except rospy.ROSInterruptException:\n        pass\n')],
    [("if __name__ == '__main__':\n    main()", 'main()')],
    [('publisher.publish(result)', 'publisher.publish(result)\n\n    import time\n    time.sleep(1)')],
    [(SUBSCRIBER, ('    import message_filters\n'
                  "    message_filters.Subscriber('/camera', Image).registerCallback(callback)\n"))],
])
def test_other_ways_are_fine(fault_of, edits):
    assert fault_of(fault_of_plumbing, *edits) is None

