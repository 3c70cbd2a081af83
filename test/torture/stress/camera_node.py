"""A simulated camera that drives past the wall, in bgr8. Arguments: width, height, frames per second."""
import sys
from itertools import cycle

import rospy
from aruco_ar.simulation.robot import Camera
from aruco_node.messages.images import image_from_frame
from aruco_node.messages.wall_messages import camera_info
from rig.accuracy.drives import LIVELY, WIDE, drive
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

MEMORY_BYTES = 1 << 28  # for the frames, which are rendered in advance


def main(width, height, rate):
    rospy.init_node('camera')
    count = max(4, min(90, MEMORY_BYTES // (3 * width * height)))
    path = LIVELY if 4 * height >= 3 * width else WIDE
    frames = [frame.image for frame in drive(path, count, noise=2.0, light=0.3, size=(width, height))]
    images = rospy.Publisher('camera/rgb/image_raw', Image, queue_size=1)
    infos = rospy.Publisher('camera/rgb/camera_info', CameraInfo, queue_size=1)
    pause = rospy.Rate(rate)
    for frame in cycle(frames + frames[::-1]):
        header = Header(stamp=rospy.Time.now(), frame_id='camera')
        infos.publish(camera_info(Camera(width, height), header))
        images.publish(image_from_frame(frame, header))
        pause.sleep()
        if rospy.is_shutdown():
            break


if __name__ == '__main__':
    try:
        main(*(int(argument) for argument in sys.argv[1:4]))
    except rospy.ROSInterruptException:  # while it waited for the next frame
        pass
