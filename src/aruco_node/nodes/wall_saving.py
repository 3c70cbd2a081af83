"""Saving what was learned of walls, so that they are known from the first frame on."""
from aruco_ar.tracking.learned_wall import shows_without_tags
from aruco_ar.walls.remembered import WALL_SUFFIX

from aruco_node.health.snapshot import new_path

WITHOUT_TAGS = 'by any of its tags, and also without them'
WITH_TAGS = 'by any of its tags, but not without them: it was seen too briefly, or has too little texture'


def save_walls(walls, folder):
    """Write RememberedWalls into a folder, one file for each. Returns a sentence about each.

    The page finds the path in it. Raises InputError if that fails.
    """
    sentences = []
    for number, wall in enumerate(walls, 1):
        path = new_path(folder, 'wall%s%s' % (number if len(walls) > 1 else '', WALL_SUFFIX))
        wall.save(path)
        sentences.append('Wrote %s. With wall:=%s, the area is found %s.'
                         % (path, path, WITHOUT_TAGS if shows_without_tags(wall) else WITH_TAGS))
    return ' '.join(sentences)
