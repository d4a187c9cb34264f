"""Folders of ROS 1 definitions, in the active workspaces and in Debian's packages."""

import contextlib
import os
import pathlib
import sys
from typing import Dict, Iterable, Iterator, List, Optional, Tuple

import rospkg

#: Debian's folder of packages.
SHARE = pathlib.Path("/usr/share")


def package_folder(packages: rospkg.RosPack, name: str) -> Optional[pathlib.Path]:
    """Return the folder of a package's definitions, or None.

    :param packages: ROS 1's packages; Debian also has definitions without a package.xml
    """
    with contextlib.suppress(rospkg.ResourceNotFound):
        return pathlib.Path(packages.get_path(name))
    place = SHARE / name
    return place if any((place / kind).is_dir() for kind in ("msg", "srv")) else None


def names_in_package(packages: rospkg.RosPack, package: str, kind: str) -> List[str]:
    """Return the names of a ROS 1 package's types of one kind, without the package.

    :param kind: ``msg``, ``srv`` or ``action``
    """
    place = package_folder(packages, package)
    found = place.glob(f"{kind}/*.{kind}") if place is not None else ()
    return sorted(path.stem for path in found)


def shared_types(others: Iterable[str] = ()) -> Iterator[Tuple[str, str]]:
    """Yield kind and name of each ROS 1 type in packages that ROS 2 also has.

    :param others: additional ROS 1 packages, whose names differ in ROS 2
    """
    packages = rospkg.RosPack()
    index = pathlib.Path(sys.prefix, "share", "ament_index", "resource_index")
    for package in sorted({*os.listdir(str(index / "rosidl_interfaces")), *others}):
        for kind in ("msg", "srv", "action"):
            for name in names_in_package(packages, package, kind):
                yield kind, f"{package}/{name}"


class DefinitionFolders(Dict[str, List[str]]):
    """Folders of definitions by package, searched when genmsg requests them."""

    def __init__(self, packages: rospkg.RosPack) -> None:
        super().__init__()
        self.packages = packages

    def __contains__(self, package: object) -> bool:
        return package_folder(self.packages, str(package)) is not None

    def __getitem__(self, package: str) -> List[str]:
        folder = package_folder(self.packages, package)
        if folder is None:
            return []
        # A build writes the messages of an action to another folder.
        built = [pathlib.Path(place) / "share" / package for place in _prefixes()]
        return [str(place / kind) for place in (folder, *built) for kind in ("msg", "srv")]


def _prefixes() -> List[str]:
    """Return the folders of the active ROS 1 workspaces."""
    return [place for place in os.environ.get("CMAKE_PREFIX_PATH", "").split(":") if place]
