"""A learner's code runs in a process of its own, and whatever it does there is said in a sentence."""
import json
import os
import select

import numpy as np
import pytest
from aruco_course.trial import Limits, fault_of_speed, run_function, run_program

FRAMES = [np.full((48, 64, 3), value, np.uint8) for value in (10, 20, 30)]
SHORT = Limits(call=1.0, load=2.0)


@pytest.fixture
def write(tmp_path):
    def write_file(*lines):
        path = tmp_path / 'exercise.py'
        path.write_text('import cv2\nimport numpy as np\n' + '\n'.join(lines) + '\n', encoding='utf-8')
        return str(path)
    return write_file


def of_function(path, outputs=('image',), frames=FRAMES, limits=SHORT):
    return run_function(path, 'draw', [(frame,) for frame in frames], outputs, limits)


@pytest.fixture
def fault_of_body(write):
    """The fault of a function with these lines."""
    def run(*lines, **named):
        fault = of_function(write('def draw(image):', *('    ' + line for line in lines)), **named).fault
        assert fault
        return fault
    return run


def test_the_images_of_all_calls_come_back(write):
    trial = of_function(write('def draw(image):', '    image[:10] += 1', '    return image'))
    assert trial.fault is None
    assert [image[0, 0].tolist() for image, in trial.images] == [[11] * 3, [21] * 3, [31] * 3]
    assert len(trial.seconds) == 3
    assert trial.baseline_seconds > 0


def test_a_frame_that_is_drawn_on_is_not_drawn_on_again(write):
    path = write('def draw(image):', '    image += 1', '    return image')
    trial = of_function(path, frames=[FRAMES[0]] * 3)
    assert [image[0, 0, 0] for image, in trial.images] == [11] * 3
    assert FRAMES[0][0, 0, 0] == 10


def test_arguments_may_be_numbers_and_pictures(write):
    path = write('def draw(image, picture, number):', '    return image + picture + number')
    trial = run_function(path, 'draw', [(FRAMES[0], FRAMES[1], 3)])
    assert trial.images[0][0][0, 0, 0] == 33


def test_gray_and_smaller_images_are_fine(write):
    path = write('def draw(image):', '    small = cv2.resize(image, None, fx=0.7, fy=0.7)',
                 '    return cv2.cvtColor(small, cv2.COLOR_BGR2GRAY)')
    trial = of_function(path)
    assert trial.fault is None
    assert trial.images[0][0].shape == (34, 45)


def test_several_outputs(write):
    trial = of_function(write('def draw(image):', '    return image[..., 0], image'), ('mask', 'image'))
    assert trial.fault is None
    assert [image.ndim for image in trial.images[0]] == [2, 3]


def test_what_is_printed_is_kept(write):
    path = write('import sys', 'def draw(image):', "    print('Grüße')", "    print('more', file=sys.stderr)",
                 '    return image')
    assert of_function(path).printed == 3 * 'Grüße\nmore\n'


def test_a_file_beside_it_can_be_imported(write, tmp_path):
    (tmp_path / 'process.py').write_text('def same(image):\n    return image\n')
    path = write('from process import same', 'def draw(image):', '    return same(image)')
    assert of_function(path).fault is None
    assert not (tmp_path / '__pycache__').exists()


def test_no_name_of_ours_is_in_the_way(write):
    path = write('import sys', 'def draw(image):',
                 "    assert 'describe' not in sys.modules and not any('inside' in one for one in sys.path)",
                 '    return image')
    assert of_function(path).fault is None


@pytest.mark.parametrize('lines, place, said', [
    (['while True:', '    pass'], 'Line', 'did not come to its end within 1 seconds'),
    (['while True:', '    try:', '        image += 1', '    except BaseException:', '        pass'],
     'Line', 'end'),
    (['import time', 'time.sleep(99)'], 'Line 5', 'must not wait'),
    (['while True:', "    print('x' * 999)"], 'Line 5', 'prints without end'),
    (['return np.ones(1 << 31, np.uint8)'], 'Line 4', 'more memory'),
    (['many = []', 'while True:', '    many.append(np.empty(1 << 28, np.uint8))'], 'Line 6', 'more memory'),
    (['raise SystemExit'], 'Line 4', 'ends the whole program'),
    (['import sys', 'sys.exit(3)'], 'Line 5', 'use return'),
    (['import os', 'os._exit(0)'], 'Line 5', 'os._exit'),
    (['import ctypes', 'ctypes.string_at(0)'], 'Line 5', 'SIGSEGV'),
    (['import os', 'os.abort()'], 'Line 5', 'SIGABRT'),
    (['import os, signal', 'os.kill(os.getpid(), signal.SIGKILL)'], 'Frame 1', 'killed by the system'),
    (["input('Which?')"], 'Line 4', 'no keyboard'),
    (['return draw(image)'], 'Line 4', 'calls itself'),
    (['import nowhere_to_be_found'], 'Line 4', 'no module nowhere_to_be_found'),
    (['import nunpy'], 'Line 4', 'Is numpy meant'),
    (['return imagee'], 'Line 4', 'Is image meant'),
    (['cv2.imshow("a", image)', 'return image'], 'Line 4', 'Leave it out'),
    (['import rospy', 'rospy.init_node("me")'], 'Line 5', 'belongs into main()'),
    (['import rospy', 'try:', '    rospy.spin()', 'except Exception:', '    return image'], 'Line 6', 'main()'),
])
def test_what_ends_the_code_is_said_with_its_line(fault_of_body, lines, place, said):
    fault = fault_of_body(*lines)
    assert fault.place.startswith(place)
    assert said in fault.what


@pytest.mark.parametrize('lines, said', [
    (['pass'], 'lacks the line "return image"'),
    (['if image[0, 0, 0] > 10:', '    return None', 'return image'], 'returned None here'),
    (['return image, image'], '2 values'),
    (['return image,'], 'comma'),
    (['return image.tolist()'], 'a list'),
    (['return image / 255'], '(image * 255).astype(np.uint8)'),
    (['return image * 1.0'], 'from 10 to 10'),
    (['return image > 5'], 'True and False'),
    (['return image.astype(int)'], 'int64'),
    (['return np.zeros((4, 2))'], 'points'),
    (['return np.dstack([image, image])'], 'height x width x 3'),
    (['return np.zeros((9999, 9999, 3), np.uint8)'], 'far too large'),
    (['return image[:40]'], 'a part of it is missing'),
    (['return cv2.resize(image, (48, 64))'], 'exchanged'),
    (['return cv2.resize(image, (50, 50))'], 'proportions'),
    (['yield image'], 'yield'),
    (['return "image"'], "'image', not an image"),
])
def test_what_is_returned_must_be_an_image_of_the_frame(fault_of_body, lines, said):
    assert said in fault_of_body(*lines).what


def test_a_frame_without_return_is_named(write):
    trial = of_function(write('def draw(image):', '    if image[0, 0, 0] < 20:', '        return image'))
    assert trial.fault.place == 'Frame 2'
    assert len(trial.images) == 1


def test_mask_and_image_in_the_wrong_order_are_told(fault_of_body):
    fault = fault_of_body('mask = np.zeros_like(image)', 'mask[:20] = 255', 'return image, mask',
                          outputs=('mask', 'image'))
    assert 'return mask, image' in fault.what


def test_one_image_instead_of_two_is_told(fault_of_body):
    assert '"return mask, image"' in fault_of_body('return image', outputs=('mask', 'image')).what


def test_a_line_of_a_file_beside_it_is_told(write, tmp_path):
    (tmp_path / 'helping.py').write_text('def go():\n    return 1 / 0\n')
    fault = of_function(write('import helping', 'def draw(image):', '    return helping.go()')).fault
    assert fault.place == 'Line 5'
    assert 'helping.py, line 2' in fault.what


def test_an_import_without_end_is_ended(write):
    fault = of_function(write('while True:', '    pass', 'def draw(image):', '    return image')).fault
    assert fault.place in ('Line 3', 'Line 4')
    assert 'not imported within 2 seconds' in fault.what


def test_a_function_that_is_made_nowhere_is_missing(write):
    assert 'no function draw' in of_function(write('draw = None')).fault.what


def test_a_file_that_is_gone(tmp_path):
    assert 'is not there' in of_function(str(tmp_path / 'exercise.py')).fault.what


def test_a_file_that_deletes_itself(write):
    path = write('import os', 'os.remove(__file__)', 'def draw(image):', '    return 1 / 0')
    assert of_function(path).fault.place == 'Line 6'


def test_threads_that_go_on_do_not_hold_it_up(write):
    path = write('import threading', 'import time', 'def draw(image):',
                 '    threading.Thread(target=time.sleep, args=(999,)).start()', '    return image')
    assert of_function(path).fault is None


@pytest.mark.parametrize('end', ['return image', 'while True: pass', 'import os; os._exit(1)'])
def test_processes_that_it_started_are_ended(write, tmp_path, end):
    fifo = str(tmp_path / 'fifo')
    os.mkfifo(fifo)
    reading = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    try:
        of_function(write('import subprocess', 'def draw(image):',
                          '    subprocess.Popen(["sleep", "999"], stdout=open(%r, "w"))' % fifo, '    ' + end))
        assert select.select([reading], [], [], 60)[0]
        assert os.read(reading, 1) == b''  # nobody has it open any more
    finally:
        os.close(reading)


def test_a_copy_of_the_process_says_nothing(write):
    trial = of_function(write('import os', 'def draw(image):', '    os.fork()', '    return image'))
    assert trial.fault is None
    assert len(trial.images) == 3


def test_what_is_no_record_of_ours_is_not_believed(write):
    record = json.dumps({'say': 'images', 'call': 1, 'seconds': 0, 'arrays': [['|O8', [1, 1]]]})
    path = write('import os', 'def draw(image):', '    for number in range(3, 20):', '        try:',
                 '            os.write(number, %r)' % (record.encode() + b'\n'), '        except OSError:',
                 '            pass', '    return image[:1]')
    trial = of_function(path)
    assert trial.fault
    assert trial.images == []


def test_slow_functions_are_told_beside_the_baseline(write):
    slow = of_function(write('import time', 'def draw(image):', '    time.sleep(0.5)', '    return image'))
    slow.baseline_seconds = 0.005
    assert slow.fault is None
    assert 'slower than the camera' in fault_of_speed(slow).what
    slow.baseline_seconds = 0.1  # a slow computer
    assert fault_of_speed(slow) is None


def test_a_program_runs_as_one(write, tmp_path):
    path = write('import os', 'def main():', '    cv2.imwrite("a.png", np.zeros((9, 9), np.uint8))',
                 '    cv2.imwrite("nowhere/a.png", np.zeros((9, 9), np.uint8))', '    print(os.getcwd())',
                 'if __name__ == "__main__":', '    main()')
    trial = run_program(path, cwd=str(tmp_path))
    assert trial.fault is None
    assert trial.printed.strip() == str(tmp_path)
    assert trial.refused == ['nowhere/a.png']
    assert (tmp_path / 'a.png').exists()


@pytest.mark.parametrize('line, said', [
    ('1 / 0', 'divides by zero'), ('while True: pass', 'did not come to its end')])
def test_a_program_that_fails(write, line, said):
    fault = run_program(write(line), SHORT).fault
    assert fault.place == 'Line 3'
    assert said in fault.what


def test_a_program_may_exit(write):
    assert run_program(write('import sys', 'sys.exit()')).fault is None


def test_ros_can_be_imported_without_ros(write, monkeypatch):
    monkeypatch.delenv('PYTHONPATH', raising=False)
    path = write('import sys',
                 'sys.path = [one for one in sys.path if not ("dist-packages" in one or "devel" in one)]',
                 'import rospy', 'import message_filters', 'from cv_bridge import CvBridge, CvBridgeError',
                 'from sensor_msgs.msg import *', 'from std_msgs.msg import Header as H',
                 'import tf2_ros.buffer',
                 'bridge = CvBridge()', 'publisher = rospy.Publisher("~image", Image, queue_size=1)',
                 'class Thing(rospy.SubscribeListener):', '    pass',
                 'def draw(image):', '    try:', '        rospy.loginfo("a")',
                 '    except (CvBridgeError, rospy.ROSException):',
                 '        pass', '    return image')
    trial = of_function(path)
    assert trial.fault is None
