"""Whom the server answers: who asks it by its own name, and no other site's page in between."""
import ipaddress
import socket
from urllib.parse import urlsplit

from aruco_ar.errors import InputError


def is_loopback(address):
    """Whether only this machine reaches that address. Raises InputError if it is no IP address."""
    try:
        return ipaddress.ip_address('127.0.0.1' if address == 'localhost' else address).is_loopback
    except ValueError:
        raise InputError('The parameter ~address is "%s"; it must be an IP address of this machine: 127.0.0.1 for '
                         'this machine alone, 0.0.0.0 for its network.' % address) from None


def is_own_name(host):
    """Whether a Host header names this machine: by an IP address, or by a name that it has itself.

    Any other name may belong to a site whose owner lets it point here, so
    that their page counts as ours (DNS rebinding).
    """
    name = urlsplit('//' + host).hostname or ''
    own = socket.gethostname().lower()
    if name in ('localhost', own, own + '.local', socket.getfqdn().lower()):
        return True
    try:
        ipaddress.ip_address(name)
        return True
    except ValueError:
        return False


def is_same_site(origin, host):
    """Whether a request with that Origin header, or None, was made by a page of that Host.

    Browsers give an origin with every POST and every websocket; what is no
    browser gives none, and no site's page can make it ask.
    """
    return origin is None or urlsplit(origin).netloc.lower() == host.lower() != ''
