"""Frames of a sheet of tags as somebody moves it in front of a camera, and the Lens of a calibration file."""
import cv2
import numpy as np
import yaml
from aruco_ar.simulation.render import WallRenderer
from aruco_ar.simulation.robot import Camera
from aruco_ar.walls.wall import load_wall
from aruco_node.messages.camera_info import lens_from_info
from sensor_msgs.msg import CameraInfo

TAGS = '[%s]' % ', '.join(
    '{id: %d, x: %.3f, y: %.3f, side: 0.16, turn: %d}'
    % (number + 20, 0.23 * (number % 4) - 0.34, 0.23 * (number // 4) + 0.76, 90 * (number % 4))
    for number in range(12))
BARREL = Camera(distortion=[-0.25, 0.07, 0.001, 0.0, 0.0])


def frames_of(camera, path, content='tags: ' + TAGS, count=36):
    """Yield frames of a wall, seen from all sides. ``content``: lines of the wall's YAML file."""
    path.write_text('wall: {width: 1.2, height: 2, plaster: 0}\n' + content)
    renderer, random = WallRenderer(load_wall(str(path)), camera, noise=1.0, blur=0.5), np.random.RandomState(3)
    for _ in range(count):
        # In wall coordinates z points to the viewer and y up; in camera coordinates z points away and y down.
        turn = cv2.Rodrigues(random.uniform(-0.55, 0.55, 3) * (1, 1, 0.4))[0] @ np.diag([1.0, -1, -1])
        depth = random.uniform(0.75, 1.3)
        side = np.tan(camera.fov / 2) * 0.6 * depth  # how far from the middle, at most
        middle = np.array([*(random.uniform(-side, side, 2) * (1.1, 0.8)), depth])
        yield renderer.render(turn, middle - turn @ (0, 1.0, 0))


def lens_of_file(path):
    """The Lens that the nodes take from a calibration file."""
    with open(path) as file:
        data = yaml.safe_load(file)
    info = CameraInfo(width=data['image_width'], height=data['image_height'],
                      distortion_model=data['distortion_model'], D=data['distortion_coefficients']['data'],
                      K=data['camera_matrix']['data'], R=data['rectification_matrix']['data'],
                      P=data['projection_matrix']['data'])
    return lens_from_info(info, (640, 480))
