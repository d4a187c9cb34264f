"""The first lines of a node's process: what has to be settled before rospy is imported."""

import importlib
import sys
import types
from typing import Any, Dict, Optional, cast


def main(node: str) -> None:
    """Run the ``main`` of a node's module.

    :param node: name of the module, e.g. ``basic_comms.nodes.talker``
    """
    _spare_imports()
    try:
        importlib.import_module(node).main()
    except KeyboardInterrupt:
        sys.exit(0)  # Ctrl-C before rospy took over the signal


def _spare_imports() -> None:
    """Leave out what ROS imports and a node does not need: a third of the time of all imports.

    The messages import numpy wherever it is installed, only to take its numbers as well as
    Python's: 30 ms and 14 MB (measured on Debian 12). roslib imports catkin's search for files,
    which rospy never asks for, and that a parser generator: 40 ms.
    """
    cast(Dict[str, Optional[object]], sys.modules).setdefault("numpy", None)
    _put_off("catkin.find_in_workspaces", "find_in_workspaces")


def _put_off(name: str, function: str) -> None:
    """Have a module imported only when its function is called.

    :param name: full name of the module, of which nothing but the function is used
    :param function: name of the function
    """
    stand_in = types.ModuleType(name)

    def call(*args: Any, **kwds: Any) -> Any:
        if sys.modules.get(name) is stand_in:
            del sys.modules[name]
        return getattr(importlib.import_module(name), function)(*args, **kwds)

    setattr(stand_in, function, call)
    sys.modules.setdefault(name, stand_in)
