"""Prints which types of ROS 1 and ROS 2 belong together."""

import os
import pathlib
import sys
from typing import Iterator, Tuple

import rospkg

from ros2_bridge.types.types import Types, Unbridgeable, package_folder


def names() -> Iterator[Tuple[str, str]]:
    """Return kind and name of each type of ROS 1 in packages that ROS 2 has too."""
    packages = rospkg.RosPack()
    index = pathlib.Path(sys.prefix, "share", "ament_index", "resource_index")
    for package in sorted(os.listdir(str(index / "rosidl_interfaces"))):
        place = package_folder(packages, package)
        if place is None:
            continue
        for kind in ("msg", "srv"):
            for path in sorted(place.glob(f"{kind}/*.{kind}")):
                yield kind, f"{package}/{path.stem}"


def print_pairs() -> None:
    """Print each pair; what is in both packages and differs, on standard error."""
    types = Types()
    for kind, name in names():
        try:
            other = types.message(name).ros2 if kind == "msg" else types.service(name).ros2
        except Unbridgeable as reason:
            print(f"not bridged: {reason}", file=sys.stderr)
            continue
        package, _, base = other.partition("/")
        print(f"{name} <=> {package}/{kind}/{base}")
