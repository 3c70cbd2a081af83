"""Which requests the server answers: those to its own name, and not those made by pages of other sites."""
import ipaddress
import re
import socket
from functools import lru_cache
from urllib.parse import urlsplit

from aruco_ar.base.errors import InputError


def is_loopback(address):
    """Whether an address can be reached only from this machine.

    Raises InputError if it is not an IP address.
    """
    try:
        return ipaddress.ip_address('127.0.0.1' if address == 'localhost' else address).is_loopback
    except ValueError:
        raise InputError('The parameter ~address is "%s"; it must be an IP address of this machine: '
                         '127.0.0.1 for this machine alone, 0.0.0.0 for its network.' % address) from None


@lru_cache(maxsize=None)
def own_names():
    """The host names of this machine."""
    name = socket.gethostname().lower()  # the full name would need a query to a name server
    return {'localhost', name, name + '.local'}


def is_own_name(host):
    """Whether a Host header names this machine: with an IP address, or with one of its own names.

    Any other name may belong to an attacker who lets it point to this machine. The browser would then treat the
    attacker's page as one of this server (DNS rebinding).
    """
    if not re.fullmatch(r'[\w.-]*(:\d+)?|\[[0-9A-Fa-f:.]+\](:\d+)?', host, re.ASCII):
        return False  # it is not just a name and a port
    try:
        name = urlsplit('//' + host).hostname or ''
        return name in own_names() or ipaddress.ip_address(name) is not None
    except ValueError:
        return False


def is_same_site(origin, host):
    """Whether a request with this Origin header, or None, was made by a page of this Host.

    Browsers send an Origin with every POST and every websocket. Other programs send none, but no web page can
    make them send a request.
    """
    try:
        return origin is None or urlsplit(origin).netloc.lower() == host.lower() != ''
    except ValueError:
        return False
