# Pure: knows no ROS.
"""Access rules: reject cross-site requests.

A page of another site can open a WebSocket to this machine, and by pointing its own name to
127.0.0.1 (DNS rebinding) it can even pass for the same site. So both headers are checked: the host
name that the browser requested, and the origin of the page.
"""

import ipaddress
import urllib.parse
from typing import Collection, List, Optional


def names_of(short: str, full: str, address: str) -> List[str]:
    """Return the names of this machine.

    :param short: host name
    :param full: host name with domain
    :param address: address or name to listen on
    :returns: these, ``localhost``, and the mDNS name,
        https://www.rfc-editor.org/rfc/rfc6762
    """
    local = short.partition(".")[0] + ".local"
    return [name.lower() for name in ("localhost", short, full, address, local)]


def is_known_name(host: str, names: Collection[str]) -> bool:
    """Return whether a request was meant for this machine.

    :param host: its header ``Host``
    :param names: names of this machine; all addresses are accepted
    """
    name = _name_of("//" + host)
    if name is None:
        return False
    try:
        ipaddress.ip_address(name)
        return True
    except ValueError:
        return name in names


def is_same_origin(origin: Optional[str], host: str) -> bool:
    """Return whether a request comes from a page that was served here.

    :param origin: its header ``Origin``; browsers always send it, other programs may not
    :param host: its header ``Host``
    """
    if origin is None:
        return True
    try:
        parts = urllib.parse.urlsplit(origin)
    except ValueError:
        return False
    return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()


def _name_of(url: str) -> Optional[str]:
    try:
        return urllib.parse.urlsplit(url).hostname
    except ValueError:
        return None
