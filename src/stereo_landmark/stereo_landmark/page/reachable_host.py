"""Returns the host name under which a browser reaches a server."""

from __future__ import annotations

import ipaddress
import socket

_DOCUMENTATION_ADDRESSES = {4: '192.0.2.1', 6: '2001:db8::1'}
"""Documentation addresses: nothing is sent, but the route to them determines this machine's own address."""


def reachable_host(host: str) -> str:
    """Return the host part of the page's address.

    Args:
        host: listening address; an unspecified address is replaced by this machine's own address.
    """
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host
    shown = _own_address(address.version) if address.is_unspecified else host
    return f'[{shown}]' if ':' in shown else shown


def _own_address(version: int) -> str:
    family = socket.AF_INET if version == 4 else socket.AF_INET6
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect((_DOCUMENTATION_ADDRESSES[version], 9))
            return str(probe.getsockname()[0])
    except OSError:
        return '127.0.0.1' if version == 4 else '::1'
