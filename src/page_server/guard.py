"""Whom the server answers: who asks it by its own name, and no other site's page in between."""
import ipaddress
import re
import socket
from functools import lru_cache
from urllib.parse import urlsplit

from aruco_ar.base.errors import InputError


def is_loopback(address):
    """Whether only this machine reaches that address. Raises InputError if it is no IP address."""
    try:
        return ipaddress.ip_address('127.0.0.1' if address == 'localhost' else address).is_loopback
    except ValueError:
        raise InputError('The parameter ~address is "%s"; it must be an IP address of this machine: '
                         '127.0.0.1 for this machine alone, 0.0.0.0 for its network.' % address) from None


@lru_cache(maxsize=None)
def own_names():
    """The names by which this machine may be asked for."""
    name = socket.gethostname().lower()  # not the full name, for which a name server would be asked
    return {'localhost', name, name + '.local'}


def is_own_name(host):
    """Whether a Host header names this machine: by an IP address, or by a name that it has itself.

    Any other name may belong to a site whose owner lets it point here, so
    that their page counts as ours (DNS rebinding).
    """
    if not re.fullmatch(r'[\w.-]*(:\d+)?|\[[0-9A-Fa-f:.]+\](:\d+)?', host, re.ASCII):
        return False  # there is more in it than a name and a port
    try:
        name = urlsplit('//' + host).hostname or ''
        return name in own_names() or ipaddress.ip_address(name) is not None
    except ValueError:
        return False


def is_same_site(origin, host):
    """Whether a request with that Origin header, or None, was made by a page of that Host.

    Browsers give an origin with every POST and every websocket; what is no
    browser gives none, and no site's page can make it ask.
    """
    try:
        return origin is None or urlsplit(origin).netloc.lower() == host.lower() != ''
    except ValueError:
        return False
