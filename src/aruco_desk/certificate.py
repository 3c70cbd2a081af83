"""HTTPS for the phone: browsers give a page the camera only over HTTPS, or on the machine itself."""
from __future__ import annotations

import ipaddress
import os
import socket
import ssl
import tempfile
from datetime import datetime, timedelta, timezone

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

LIFE = timedelta(days=7)   # of a certificate; each start makes a new one
CLOCKS = timedelta(days=1)  # by how much a phone's clock may be late
NOWHERE = '192.0.2.1', 9   # an address that nobody has: see RFC 5737


def own_address() -> str:
    """The address of this machine in its network, as far as can be told; else its name."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(NOWHERE)  # this sends nothing; it only chooses the way
            address: str = probe.getsockname()[0]
        except OSError:
            return socket.gethostname()
    return address


def made_on_the_spot(address: str) -> ssl.SSLContext:
    """TLS with a new certificate that this machine signs itself, for an address or a name."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, 'unit5 at %s' % address)])
    now = datetime.now(timezone.utc)
    certificate = (
        x509.CertificateBuilder().subject_name(name).issuer_name(name).public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - CLOCKS).not_valid_after(now + LIFE)
        .add_extension(x509.SubjectAlternativeName([_alternative(address), x509.DNSName('localhost')]), False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), True)
        .sign(key, hashes.SHA256()))
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    with tempfile.TemporaryDirectory() as folder:  # only its owner can read it
        path = os.path.join(folder, 'page.pem')
        with open(path, 'wb') as file:
            file.write(key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8,
                                         serialization.NoEncryption()))
            file.write(certificate.public_bytes(serialization.Encoding.PEM))
        context.load_cert_chain(path)
    return context


def _alternative(address: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(address))
    except ValueError:
        return x509.DNSName(address)
