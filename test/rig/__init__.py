"""What tests share: nodes, processes, hosts in a network, the page, and errors on simulated drives."""
import os
from xml.etree import ElementTree

PACKAGE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
VERSION = ElementTree.parse(os.path.join(PACKAGE, 'package.xml')).findtext('version')
