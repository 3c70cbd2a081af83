"""Saving what was learned of walls, so that they are known from the first frame on."""
from aruco_node.health.snapshot import new_path

WITHOUT_TAGS = 'by any of its tags, and also without them'
WITH_TAGS = 'by any of its tags, but not without them: it was seen too briefly, or has too little texture'


def save_walls(walls, settings, folder):
    """Write files, one for each area, into a folder. Returns a sentence about it.

    ``walls``: their LearnedWalls. ``settings``: the AreaSettings of each. Raises InputError if that fails.
    """
    sentences = []
    for number, (wall, own) in enumerate(zip(walls, settings), 1):
        path = new_path(folder, 'wall%s.npz' % (number if len(walls) > 1 else ''))
        wall.remembered(own.dictionary, own.border).save(path)
        sentences.append('Wrote %s. With wall:=%s, the area is found %s.'
                         % (path, path, WITHOUT_TAGS if wall.shows_without_tags else WITH_TAGS))
    return ' '.join(sentences)
