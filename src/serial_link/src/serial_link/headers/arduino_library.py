"""Arduino library of headers: the files that the IDE and arduino-cli expect around them."""

from typing import Dict

#: Of the library and its root header, which a sketch includes so that the library is found.
NAME = "ros_messages"
#: Under which rosserial's library is in the library manager, and the version that these suit.
ROSSERIAL, ROSSERIAL_VERSION = "Rosserial Arduino Library", "0.7.8"

_PROPERTIES = """\
name={name}
version={version}
author=serial_link
maintainer=serial_link
sentence=Messages and services of {packages} for {rosserial} {rosserial_version}.
paragraph=Made by serial_link's make_headers.
category=Communication
url=http://wiki.ros.org/rosserial
architectures=*
includes={name}.h
depends={rosserial} (={rosserial_version})
"""


def arduino_library(headers: Dict[str, str], packages: str, version: str) -> Dict[str, str]:
    """Return the files of a library by their paths.

    :param headers: by their paths, which stay below ``src``
    :param packages: whose they are, in words
    :param version: of the library, three numbers with points
    """
    properties = _PROPERTIES.format(
        name=NAME,
        version=version,
        packages=packages,
        rosserial=ROSSERIAL,
        rosserial_version=ROSSERIAL_VERSION,
    )
    includes = "".join(f'#include "{path}"\n' for path in sorted(headers))
    root = f"// Made by serial_link's make_headers.\n#pragma once\n\n{includes}"
    return {
        f"{NAME}/library.properties": properties,
        f"{NAME}/src/{NAME}.h": root,
        **{f"{NAME}/src/{path}": text for path, text in headers.items()},
    }
