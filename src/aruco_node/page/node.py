"""The node page: image topics, driving, and the parameters of the nodes, in a browser."""
import asyncio
import logging
from dataclasses import dataclass
from typing import Any

import rospy
from aruco_ar.settings.declaration import Settings, number, text
from page_server.access import is_loopback
from page_server.server import Site, address_of_page, listen
from page_server.tiles import TILES
from tornado.ioloop import PeriodicCallback

from aruco_node.health.diagnostics import OK, Diagnostics
from aruco_node.health.faults import note_fault
from aruco_node.nodes.node import read_settings
from aruco_node.parameters.parameters import AUTO, switch
from aruco_node.parameters.reconfigure import Reconfigurer

from .advice import Advice
from .driving import DriveControl
from .remote import NodeChoices
from .topics import Topics

DIAGNOSTICS_MS = 250


@dataclass(frozen=True)
class PageSettings(Settings):
    """The parameters of the page. After a change of their defaults or words, run script/remake/launch_args."""

    address: str = text(
        '127.0.0.1', 'an IP address, or localhost',
        'address at which the page is served. 127.0.0.1: only this machine can open the page. 0.0.0.0: its '
        'whole network can', live=False)
    port: float = number(8080, 1, 65535, 'port at which the page is served', live=False)
    drive: Any = switch(
        AUTO, 'whether the page may drive the robot. auto: it may if it is served to this machine only')
    linear: float = number(0.3, 0, 2, 'speed at which the page drives the robot, in m/s')
    angular: float = number(0.8, 0, 8, 'speed at which the page turns the robot, in rad/s')


class NodeSite(Site):
    """The Site of the image topics that are published, and of the nodes."""

    def __init__(self, drive_control, tiles, loop):
        super().__init__(tiles, loop)
        self.drive_control = drive_control
        self.topics, self.choices = Topics(), NodeChoices(self.on_change)
        self._advice = Advice([tile.node for tile in tiles], self.on_change)

    def now(self):
        return rospy.Time.now().to_sec()

    def advice_of(self, node):
        return self._advice.of(node)


def serve():
    """Serve the page until ROS shuts down. Raises InputError if it cannot be served."""
    settings = read_settings(PageSettings)
    address, port = settings.address, int(settings.port)
    for name in ('tornado.application', 'asyncio'):  # their errors go where the node's other faults go
        logging.getLogger(name).parent = logging.getLogger('rosout')
        logging.getLogger(name).addFilter(_note_faults)
    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    drive_control = None
    if is_loopback(address) if settings.drive == AUTO else settings.drive:
        drive_control = DriveControl()
        drive_control.set_speeds(settings)
    Reconfigurer(settings, drive_control.set_speeds if drive_control else lambda settings: None)
    tiles = [tile._replace(topic=rospy.resolve_name(tile.topic), tags=rospy.resolve_name(tile.tags))
             for tile in TILES]
    site = NodeSite(drive_control, tiles, loop)
    server = listen(site, address, port)
    diagnostics = Diagnostics(lambda: (OK, 'The page is served.', {
        'connections': server.count, 'pages open': len(site.browsers),
        'driving': 'on' if drive_control else 'off'}))
    PeriodicCallback(diagnostics.update, DIAGNOSTICS_MS).start()
    rospy.on_shutdown(lambda: loop.call_soon_threadsafe(loop.stop))
    rospy.loginfo('The page is at %s (driving is %s)', address_of_page(address, port),
                  'on' if drive_control else 'off')
    loop.run_forever()
    server.stop()


def _note_faults(record):
    """A filter of log records: notes an exception as a fault of the node, and does not log it a second time."""
    if record.exc_info:
        note_fault(record.exc_info[1])
    return not record.exc_info
