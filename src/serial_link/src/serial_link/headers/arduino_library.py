"""Arduino library of headers, with the files that the IDE and arduino-cli expect."""

from typing import Dict

#: Name of the library, and of the root header by which a sketch includes it.
NAME = "ros_messages"
#: Name of rosserial's library in the library manager, and the version that these headers need.
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
    """Return the files of a library by path.

    :param headers: by path, relative to ``src``
    :param packages: names of their packages, as text
    :param version: of the library, three numbers separated by dots
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
