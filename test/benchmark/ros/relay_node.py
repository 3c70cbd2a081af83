"""A bare rospy relay with the same memory settings as our nodes."""
import rospy
from aruco_node.process.memory import keep_memory
from sensor_msgs.msg import Image

keep_memory()
rospy.init_node('relay')
publisher = rospy.Publisher('result', Image, queue_size=1)
rospy.Subscriber('camera/rgb/image_raw', Image, publisher.publish, queue_size=1, buff_size=1 << 26)
rospy.spin()
