"""Explains why no frames arrive."""
import re

from aruco_node.messages.topics import IMAGE_TYPES, SUFFIX, raw_topic

# Images that are not from cameras.
OURS = re.compile(r'/(exercise5_\d/(image|mask)|(tag_poses|calibrate_live)/image|page/picture)(/|$)')
SILENCE_S = 5.0  # after this time without a message, the node says why


def explain_silence(camera, transport, published, own=()):
    """A sentence that says why no frames arrive, and what to do.

    ``camera``: the resolved name of the camera's raw topic. ``transport``: raw or compressed. ``published``:
    {topic: type} of all topics that have a publisher. ``own``: the node's topics, which are not cameras.
    """
    wanted = camera + (SUFFIX if transport == 'compressed' else '')
    waiting = 'Waiting for frames on %s: ' % wanted
    if wanted in published:
        if transport == 'raw' and wanted.endswith(SUFFIX) and published[wanted] == IMAGE_TYPES['compressed']:
            return waiting + 'this is a compressed topic. Give camera:=%s transport:=compressed.' % \
                raw_topic(wanted)
        if published[wanted] != IMAGE_TYPES[transport]:
            return waiting + ('it is published as %s, but must be %s. Give the topic of a camera: '
                              'camera:=TOPIC.' % (published[wanted], IMAGE_TYPES[transport]))
        return waiting + 'it has a publisher, but nothing arrives. Is the camera running?'
    if transport == 'raw' and camera + SUFFIX in published:
        return waiting + ('only its compressed form %s is published. Give '
                          'transport:=compressed.' % (camera + SUFFIX))
    if transport == 'compressed' and camera in published:
        return waiting + 'only its raw form %s is published. Give transport:=raw.' % camera
    cameras = sorted(topic for topic, kind in published.items()
                     if kind == IMAGE_TYPES[transport] and topic not in own and not OURS.search(topic))
    if cameras:
        names = [raw_topic(name) if transport == 'compressed' else name for name in cameras]
        return waiting + ('nothing publishes it. These are published: %s. Choose one: '
                          'camera:=TOPIC.' % ', '.join(names))
    return waiting + ('nothing publishes it, nor any other %s. Start a camera, or try sim:=true.'
                      % IMAGE_TYPES[transport])
