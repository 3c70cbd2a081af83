"""Things that stand on a sheet with tags, while a camera goes round them: what keep leaves in front."""
import os
from collections import namedtuple

import cv2
import numpy as np
from aruco_ar.base.progress import tell
from aruco_ar.tags.tag import draw_tag
from rig import PACKAGE

from .painter import Painter

SIZE = 960, 540
CAMERA = np.array([[800.0, 0, 480], [0, 800, 270], [0, 0, 1]])
# Lengths in millimeters from the middle of the sheet: to the right, to its top, and up toward the camera.
TABLE, SHEET = (1400, 1100), (420, 297)
TAG, TAGS_AT = 50, (175, 113)  # a tag's side; the tags' centers are so far to the right, and toward the top
WHITE_RIM = 8                  # around tags on a pattern
TEXELS = 2                     # for each millimeter
AWAY = 760                     # of the camera
FINER = 2                      # things are rendered with so many times as many pixels, and shrunk
NOISE, BLUR_PX, EXPOSURE = 2.0, 0.7, 0.05
LIGHT = np.array([-0.45, 0.35, 0.82])
RIM_PX = 3                     # width of the band around a thing that is judged
PAINT = 60, 200, 60            # BGR: nothing in the scene has this color
FIRST_S = 1.0                  # what is painted before is not judged

# ``box``: whether it is a box, and else an ellipsoid. ``middle``: on the sheet. ``half``: its half axes.
# ``color``: BGR. ``grain``: how much its brightness varies.
Thing = namedtuple('Thing', 'box middle half turn color grain')
# ``things``: {name: (h, w) float32, the share of each pixel that it covers}. ``inside``: (h, w) bool, the area.
Moment = namedtuple('Moment', 'stamp frame things inside')
THINGS = {
    'red box': Thing(True, (-75, 28), (30, 18, 24), 0.4, (38, 36, 175), 0.03),
    'gray stone': Thing(False, (45, -35), (33, 25, 20), -0.3, (128, 131, 134), 0.16),
    'dark case': Thing(True, (70, 60), (45, 17, 11), 0.15, (52, 42, 38), 0.05)}


def paper(name):
    """(h, w, 3) BGR uint8: the ground of a sheet of that name, one of GROUNDS."""
    width, height = (TEXELS * length for length in SHEET)
    y, x = np.mgrid[:height, :width].astype(np.float32)
    if name == 'print':
        return cv2.resize(cv2.imread(os.path.join(PACKAGE, 'images', 'earth.jpg')), (width, height))
    if name == 'wallpaper':
        flowers = np.cos(x / 18) * np.cos(y / 18) > 0.35
        image = np.where(flowers[..., None], (150, 110, 90), (205, 215, 220)).astype(np.uint8)
        return cv2.GaussianBlur(image, (0, 0), 1.5)
    return np.full((height, width, 3), (226, 229, 231), np.uint8)


GROUNDS = 'plain', 'print', 'wallpaper'


def table(ground):
    """(h, w, 3) BGR float32: the table with the sheet and with the shadows of the things."""
    width, height = (TEXELS * length for length in TABLE)
    random = np.random.RandomState(7)
    grain = cv2.GaussianBlur(random.normal(0, 30, (height, width)).astype(np.float32), (0, 0), 9, sigmaY=2)
    image = np.clip((1 + grain / 40)[..., None] * (70, 105, 135), 0, 255).astype(np.float32)
    sheet = paper(ground)
    rim = 0 if ground == 'plain' else WHITE_RIM
    for tag_id, (right, up) in enumerate(((-1, 1), (1, 1), (1, -1), (-1, -1))):
        tag = np.pad(draw_tag('DICT_6X6_250', tag_id, TEXELS * TAG), TEXELS * rim, constant_values=235)
        left, top = (int(TEXELS * (length / 2 + middle) - len(tag) / 2)
                     for length, middle in zip(SHEET, (right * TAGS_AT[0], -up * TAGS_AT[1])))
        sheet[top:top + len(tag), left:left + len(tag)] = np.maximum(tag, 28)[..., None]
    left, top = ((length - len_sheet) // 2 for length, len_sheet in zip((width, height), sheet.shape[1::-1]))
    image[top:top + sheet.shape[0], left:left + sheet.shape[1]] = sheet
    shade = np.zeros((height, width), np.float32)
    for thing in THINGS.values():
        # Where it stands, and where it keeps the light off.
        for up, soft, dark in ((0.15, 5, 0.4), (1.0, 16, 0.3)):
            part = np.zeros_like(shade)
            middle = np.array(thing.middle) - up * thing.half[2] * LIGHT[:2] / LIGHT[2]
            at = (TEXELS * (middle * (1, -1) + np.array(TABLE) / 2)).tolist()
            size = [2 * TEXELS * half for half in thing.half[:2]]
            cv2.ellipse(part, (at, size, -np.degrees(thing.turn)), 1, -1)
            shade = np.maximum(shade, dark * cv2.GaussianBlur(part, (0, 0), TEXELS * soft / 2))
    return image * (1 - shade[..., None])


def view(around, tilt):
    """(R, t): of a camera that looks at the middle of the sheet, radians round it and from the vertical."""
    place = AWAY * np.array([np.sin(tilt) * np.sin(around), -np.sin(tilt) * np.cos(around), np.cos(tilt)])
    forward = -place / AWAY
    right = np.array([np.cos(around), np.sin(around), 0])
    rotation = np.stack([right, np.cross(forward, right), forward])
    return rotation, -rotation @ place


def on_plane(rotation, translation):
    """(3, 3): the homography from the plane of the sheet, millimeters, to pixels."""
    return CAMERA @ np.column_stack([rotation[:, 0], rotation[:, 1], translation])


def seen_thing(thing, rotation, translation):
    """(rows and columns, (h, w, 3), (h, w)): where a thing is, its colors, and how much it covers."""
    cos, sin = np.cos(thing.turn), np.sin(thing.turn)
    to_own = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    half = np.array(thing.half, float)
    middle = np.array([*thing.middle, half[2]])
    corners = middle + half * np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T @ to_own
    spots = corners @ rotation.T + translation
    spots = FINER * ((spots @ CAMERA.T)[:, :2] / spots[:, 2:])
    low = np.maximum(np.floor(spots.min(axis=0) / FINER).astype(int) - 1, 0)
    high = np.minimum(np.ceil(spots.max(axis=0) / FINER).astype(int) + 2, SIZE)
    (left, top), (right, foot) = FINER * low, FINER * high
    y, x = np.mgrid[top:foot, left:right]
    rays = np.stack([(x + 0.5) / FINER - 0.5, (y + 0.5) / FINER - 0.5, np.ones(x.shape)], axis=-1)
    rays = (rays @ np.linalg.inv(CAMERA).T @ rotation @ to_own.T) / half
    eye = to_own @ (-rotation.T @ translation - middle) / half
    if thing.box:
        ends = np.sort(np.stack([(-1 - eye) / rays, (1 - eye) / rays]), axis=0)
        near, hit = ends[0].max(axis=-1), ends[0].max(axis=-1) < ends[1].min(axis=-1)
    else:
        a, b, c = (rays**2).sum(-1), (rays * eye).sum(-1), (eye**2).sum() - 1
        root = b * b - a * c
        near, hit = (-b - np.sqrt(np.maximum(root, 0))) / a, root > 0
    point = eye + near[..., None] * rays
    normal = np.where(np.abs(point) > 1 - 1e-6, np.sign(point), 0) if thing.box else point / half
    normal = normal / np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-9)
    shade = 0.45 + 0.6 * np.maximum(normal @ to_own @ LIGHT, 0)
    spots = np.sin(point @ (9, 4, 13)) * np.sin(point @ (-5, 11, 7) + 1) + 0.7 * np.sin(point @ (23, -17, 31))
    colors = (shade * (1 + thing.grain * spots) * hit)[..., None] * thing.color
    size = tuple((high - low).tolist())
    colors, cover = (cv2.resize(each.astype(np.float32), size, interpolation=cv2.INTER_AREA)
                     for each in (colors, hit))
    return (slice(low[1], high[1]), slice(low[0], high[0])), colors / np.maximum(cover, 1e-3)[..., None], cover


def stills():
    """Yield (stamp, around, tilt) of four stills a second all round the sheet, 9 degrees apart."""
    for number in range(40):
        yield number / 4, 0.16 * number, 0.72 + 0.08 * np.sin(0.5 * number)


def pan():
    """The same for a smooth motion to and fro."""
    for number in range(90):
        yield number / 15, 0.6 * np.sin(2 * np.pi * number / 120), 0.6 + 0.1 * np.sin(0.04 * number)


MOTIONS = {'stills': stills, 'pan': pan}


def moments(ground, motion, standing=tuple(THINGS)):
    """Yield the Moments of a motion, one of MOTIONS, above a ground with some of the THINGS."""
    image, random = table(ground), np.random.RandomState(2)
    to_table = np.array([[1 / TEXELS, 0, -TABLE[0] / 2 + 0.5 / TEXELS],
                         [0, -1 / TEXELS, TABLE[1] / 2 - 0.5 / TEXELS], [0, 0, 1]])
    corners = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1]], float) * TAGS_AT
    noise = random.normal(0, NOISE, (SIZE[1], SIZE[0], 3)).astype(np.float32)
    for number, (stamp, around, tilt) in enumerate(MOTIONS[motion]()):
        rotation, translation = view(around, tilt)
        homography = on_plane(rotation, translation)
        frame = cv2.warpPerspective(image, homography @ to_table, SIZE, flags=cv2.INTER_AREA)
        seen = [(seen_thing(THINGS[name], rotation, translation), name) for name in standing]
        eye = -rotation.T @ translation
        seen.sort(key=lambda each: -np.linalg.norm(eye[:2] - THINGS[each[1]].middle))
        covers = {}
        for (part, colors, cover), name in seen:
            frame[part] += cover[..., None] * (colors - frame[part])
            for other in covers.values():
                other[part] *= 1 - cover
            covers[name] = np.zeros(frame.shape[:2], np.float32)
            covers[name][part] = cover
        frame = cv2.GaussianBlur(frame, (0, 0), BLUR_PX) * (1 + EXPOSURE * np.sin(0.9 * stamp))
        frame = np.clip(np.round(frame + np.roll(noise, (37 * number, 91 * number), (0, 1))), 0, 255)
        outline = cv2.perspectiveTransform(corners[None], homography)
        yield Moment(stamp, frame.astype(np.uint8), covers, well_inside(outline, SIZE))


def well_inside(outline, size):
    """(h, w) bool: the pixels of a frame in an outline, (4, 2), but for two along its rim. ``size``: (w, h)."""
    inside = np.zeros(size[::-1], np.uint8)
    cv2.fillConvexPoly(inside, np.int32(np.round(outline * 16)), (1,), cv2.LINE_8, 4)
    return cv2.erode(inside, np.ones((5, 5))) > 0


def judge(moment, image):
    """(8,): what is judged in a painted frame: sums of shares of pixels, each with the number of these pixels.

    What is kept of the things, what is painted of the wall, the bare wall in a band around the things, and
    what is kept of the thing of which least is kept.
    """
    frame, paint = moment.frame.astype(np.float32), np.float32(PAINT)
    contrast = frame - paint
    share = np.clip(((image - paint) * contrast).sum(axis=2) / np.maximum((contrast**2).sum(axis=2), 1), 0, 1)
    share = np.where(moment.inside, share, 0)
    covers = {name: cover * moment.inside for name, cover in moment.things.items()}
    front = np.minimum(sum(covers.values()), 1)
    wall = moment.inside & (front == 0)
    window = np.ones((2 * RIM_PX + 1,) * 2, np.uint8)
    band = wall & (cv2.dilate(np.uint8(front > 0.5), window) > 0)
    kept = {name: (np.minimum(share, cover).sum(), cover.sum()) for name, cover in covers.items()}
    least = min(kept.values(), key=lambda sums: sums[0] / max(sums[1], 1))
    return np.array([np.minimum(share, front).sum(), front.sum(), (1 - share)[wall].sum(), wall.sum(),
                     (share[band] > 0.5).sum(), band.sum(), *least])


def run():
    """Print the table."""
    tell('\nforeground:=keep, things that stand on a sheet from the first frame on while the camera goes\n'
         'round: what is kept of them (mean, worst frame, worst thing in a frame), how much of the wall is\n'
         'painted (mean, worst frame), and bare wall in a band of %d pixels around them\n\n'
         '%-20s %8s %8s %8s %10s %8s %10s' % (RIM_PX, '', 'kept', 'worst', 'thing', 'painted', 'worst', 'bare'))
    for ground in GROUNDS:
        for motion in MOTIONS:
            painter = Painter(np.full((60, 90, 3), PAINT, np.uint8), foreground='keep')
            sums = []
            for moment in moments(ground, motion):
                image = painter.paint(moment.frame, moment.stamp)[1]
                if moment.stamp >= FIRST_S:
                    sums.append(judge(moment, image))
            tell(row('%s, %s' % (ground, motion), np.array(sums)))


def row(name, sums):
    """A line of the table, for what judge says about frames."""
    shares = 100 * sums[:, ::2] / np.maximum(sums[:, 1::2], 1)
    kept, painted, bare, _ = 100 * sums.sum(axis=0)[::2] / np.maximum(sums.sum(axis=0)[1::2], 1)
    return '%-20s %6.1f %% %6.1f %% %6.1f %% %8.1f %% %6.1f %% %8.1f %%' % (
        name, kept, shares[:, 0].min(), shares[:, 3].min(), painted, shares[:, 1].min(), bare)
