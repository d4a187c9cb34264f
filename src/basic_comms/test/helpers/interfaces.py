"""Interfaces that users rely on: those of a running node, and those of packages."""

import importlib.util
import pathlib
from typing import Any, Dict, List, Set
from xml.etree import ElementTree

import rosgraph
import roslib.message
import rosservice

import nodekit
import nodekit.testing

#: Modules of nodekit that are public beside its own names.
MODULES = ("entry_point", "lifecycle_states", "master", "message_definitions")
#: Types of registrations, in the master's order.
KINDS = ("publishes", "subscribes", "services")


class Registrations:
    """Registrations made since this object was created."""

    def __init__(self) -> None:
        self._master = rosgraph.Master("/registrations")
        self._earlier = self._names()

    def _names(self) -> Dict[str, Set[str]]:
        state = self._master.getSystemState()
        return {kind: {name for name, _ in part} for kind, part in zip(KINDS, state)}

    def of(self, node: str) -> Dict[str, Dict[str, str]]:
        """Return names and types that a node has registered, without earlier registrations.

        Those of optional packages are left out.

        :param node: its global name
        """
        names = self._names()
        types = dict(self._master.getTopicTypes())  # after the names, so that each has a type
        services = names["services"] - self._earlier["services"]
        types.update((name, rosservice.get_service_type(name)) for name in services)
        return {
            kind: {
                local(name, node): types[name]
                for name in names[kind] - self._earlier[kind]
                if not types[name].startswith("dynamic_reconfigure/")
            }
            for kind in KINDS
        }


def local(name: str, node: str) -> str:
    """Return a name as in the node's code: private, relative or global."""
    if name.startswith(node + "/"):
        return "~" + name[len(node) + 1 :]
    space = rosgraph.names.namespace(node)
    return name[len(space) :] if name.startswith(space) else name


def of_packages(sources: pathlib.Path) -> Dict[str, Any]:
    """Return the contents of packages, and the names of nodekit.

    :param sources: the folder of the packages
    """
    packages = sorted(manifest.parent for manifest in sources.glob("*/package.xml"))
    return {
        "executables": {
            package.name: sorted(
                path.name for path in (package / "scripts").iterdir() if path.is_file()
            )
            for package in packages
            if (package / "scripts").is_dir()
        },
        "launch arguments": {
            f"{package.name}/{path.name}": arguments(path)
            for package in packages
            for path in sorted((package / "launch").rglob("*.launch"))
        },
        "messages": {
            f"{package.name}/{path.stem}": digest(package.name, path)
            for package in packages
            for kind in ("msg", "srv", "action")
            for path in sorted((package / kind).glob(f"*.{kind}"))
        },
        "nodekit": sorted(nodekit.__all__),
        "nodekit modules": sorted(
            name
            for name in [*MODULES, *_testing()]
            if importlib.util.find_spec(f"nodekit.{name}") is not None
        ),
    }


def _testing() -> List[str]:
    (folder,) = nodekit.testing.__path__
    return [f"testing.{path.stem}" for path in pathlib.Path(folder).glob("[a-z]*.py")]


def arguments(launch_file: pathlib.Path) -> List[str]:
    """Return the names of the arguments that may be given to a launch file."""
    tags = ElementTree.parse(str(launch_file)).getroot().findall("arg")
    return sorted(tag.attrib["name"] for tag in tags if "value" not in tag.attrib)


def digest(package: str, path: pathlib.Path) -> str:
    """Return the fields that two nodes compare before they exchange a message or a call."""
    name = f"{package}/{path.stem}"
    if path.suffix == ".srv":
        return str(roslib.message.get_service_class(name)._md5sum)
    if path.suffix == ".action":
        name += "Action"
    return str(roslib.message.get_message_class(name)._md5sum)
