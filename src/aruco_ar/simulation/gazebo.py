"""The wall for Gazebo: a model with the tags as a textured mesh, and a world that contains it.

Coordinates are odometry coordinates (see robot.py), meters. The tags' faces
are in the plane x = 0, as for the simulated camera.
"""
from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

from aruco_ar.base.arrays import Floats
from aruco_ar.walls.wall import Wall, WallTag

from .render import FLOOR_COLOR, ROOM_COLOR
from .robot import WALL_IN_ODOMETRY

MODEL = 'unit5_wall'
MESHES = 'models/%s/meshes/' % MODEL

# Paper as thin as real paper would flicker, since depths are rounded. The ROSbot's
# camera sees from 0.1 m on. It distinguishes depths 5 mm apart up to 90 m away, or
# up to 5 m with a depth buffer of only 16 bits.
PAPER_M = 0.005
WALL_M = 0.1  # distance from the tags' faces to the wall's back

# Gazebo halves textures for far views. Even after five times, a texel is within one cell.
CELL_TEXELS = 64

# The sun shines onto the wall from the front and from above. Ambient light and sun
# together stay below 1 there, since overexposed white would eat into the tags' edges.
SUN_DIRECTION = 0.8, 0.0, -0.6
AMBIENT, SUN = 0.5, 0.5


def wall_files(wall: Wall) -> dict[str, bytes]:
    """{path: bytes}: all files for a Wall. Paths are relative to the package's gazebo/."""
    files = {'models/%s/model.config' % MODEL: _CONFIG % {'model': MODEL},
             'models/%s/model.sdf' % MODEL: _model(wall),
             'worlds/wall.world': _world(),
             MESHES + 'tags.obj': _mesh(wall),
             MESHES + 'tags.mtl': _materials(wall)}
    files = {path: text.encode() for path, text in files.items()}
    for tag in wall.tags:
        files[MESHES + 'tag_%d.png' % tag.id] = _texture(wall, tag)
    return files


def _mesh(wall: Wall) -> str:
    """The tags' papers in Wavefront's OBJ format: a textured front and four sides each.

    Gazebo needs one material for each object, and for every corner a normal and
    a position in the texture. A side shows the texture's rim. The rim has the
    same color all around, so nothing bleeds in where the texture repeats.
    """
    lines = ['mtllib tags.mtl',
             'vt 0 1', 'vt 0 0', 'vt 1 0', 'vt 1 1']  # v is up; the tag's own top left is the first
    for number, tag in enumerate(wall.tags):
        _, corners = wall.paper(tag)
        front = corners[[0, 3, 2, 1]]  # seen from outside, a face goes counterclockwise
        points = np.concatenate([front, front - [0, 0, PAPER_M]]) @ WALL_IN_ODOMETRY.T
        faces = [[0, 1, 2, 3]] + [[i + 4, j + 4, j, i] for i, j in ((0, 1), (1, 2), (2, 3), (3, 0))]
        lines += ['o tag_%d' % tag.id, 'usemtl tag_%d' % tag.id]
        lines += ['v ' + _numbers(point) for point in points]
        for count, face in enumerate(faces):
            a, b, c = points[face[:3]]
            normal = np.cross(b - a, c - b)
            lines.append('vn ' + _numbers(normal / np.linalg.norm(normal)))
            lines.append('f ' + ' '.join(
                '%d/%d/%d' % (8 * number + i + 1, i % 4 + 1, 5 * number + count + 1) for i in face))
    return '\n'.join(lines) + '\n'


def _materials(wall: Wall) -> str:
    """A material for each tag: white under its texture, and not shiny."""
    return '\n'.join('newmtl tag_%d\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd tag_%d.png\n' % (id, id)
                     for id in dict.fromkeys(tag.id for tag in wall.tags))


def _texture(wall: Wall, tag: WallTag) -> bytes:
    """A tag on its paper as the bytes of a PNG; the tag's own top left is the image's top left."""
    cells, _ = wall.paper(tag)
    texels = CELL_TEXELS // wall.paper_scale
    texture = cells.repeat(texels, 0).repeat(texels, 1)
    return cv2.imencode('.png', cv2.cvtColor(texture, cv2.COLOR_GRAY2BGR),
                        [cv2.IMWRITE_PNG_COMPRESSION, 9])[1].tobytes()


def _model(wall: Wall) -> str:
    return _MODEL % {'model': MODEL, 'color': _color(wall.color),
                     # Robots collide with the plane of the tags' faces.
                     'collision': _box(wall, 0.0), 'visual': _box(wall, PAPER_M)}


def _box(wall: Wall, behind: float) -> str:
    """The pose and geometry of the wall as SDF. ``behind``: meters from the tags' faces to the wall's front."""
    center = WALL_IN_ODOMETRY @ [0, wall.height / 2, -(behind + WALL_M) / 2]
    size = np.abs(WALL_IN_ODOMETRY @ [wall.width, wall.height, WALL_M - behind])
    return '<pose>%s 0 0 0</pose>\n        <geometry><box><size>%s</size></box></geometry>' % (
        _numbers(center), _numbers(size))


def _world() -> str:
    return _WORLD % {'model': MODEL, 'room': _color(ROOM_COLOR), 'floor': _color(FLOOR_COLOR),
                     'ambient': _numbers([AMBIENT] * 3), 'sun': _numbers([SUN] * 3),
                     'direction': _numbers(SUN_DIRECTION)}


def _color(bgr: Sequence[float]) -> str:
    return _numbers(np.array(bgr[::-1]) / 255)


def _numbers(values: Floats | Sequence[float]) -> str:
    """Numbers as text, rounded to six decimals, which is a micrometer."""
    return ' '.join('%.10g' % value for value in np.round(values, 6) + 0.0)  # + 0.0 avoids -0


_CONFIG = '''<?xml version="1.0"?>
<model>
  <name>%(model)s</name>
  <version>1.0</version>
  <sdf version="1.6">model.sdf</sdf>
  <author><name>The unit5 team</name></author>
  <description>A wall with tags, made by gazebo_wall.py.</description>
</model>
'''

_MODEL = '''<?xml version="1.0"?>
<!-- Made by gazebo_wall.py. The tags' faces are in the plane x = 0, facing -x. -->
<sdf version="1.6">
  <model name="%(model)s">
    <static>true</static>
    <link name="wall">
      <collision name="bumper">
        %(collision)s
      </collision>
      <visual name="plaster">
        %(visual)s
        <material>
          <ambient>%(color)s 1</ambient>
          <diffuse>%(color)s 1</diffuse>
          <specular>0 0 0 1</specular>
        </material>
      </visual>
      <visual name="tags">
        <cast_shadows>false</cast_shadows>
        <geometry><mesh><uri>model://%(model)s/meshes/tags.obj</uri></mesh></geometry>
      </visual>
    </link>
  </model>
</sdf>
'''

_WORLD = '''<?xml version="1.0"?>
<!-- Made by gazebo_wall.py. -->
<sdf version="1.6">
  <world name="wall">
    <scene>
      <ambient>%(ambient)s 1</ambient>
      <background>%(room)s 1</background>
      <shadows>false</shadows>
    </scene>
    <light name="sun" type="directional">
      <cast_shadows>false</cast_shadows>
      <pose>-5 0 5 0 0 0</pose>
      <diffuse>%(sun)s 1</diffuse>
      <specular>0 0 0 1</specular>
      <direction>%(direction)s</direction>
    </light>
    <gui>
      <camera name="user_camera">
        <pose>-4 1.2 1.6 0 0.25 -0.3</pose>
      </camera>
    </gui>
    <model name="floor">
      <static>true</static>
      <link name="floor">
        <collision name="ground">
          <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
        </collision>
        <visual name="tiles">
          <cast_shadows>false</cast_shadows>
          <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
          <material>
            <ambient>%(floor)s 1</ambient>
            <diffuse>%(floor)s 1</diffuse>
            <specular>0 0 0 1</specular>
          </material>
        </visual>
      </link>
    </model>
    <include>
      <uri>model://%(model)s</uri>
    </include>
  </world>
</sdf>
'''
