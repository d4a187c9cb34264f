"""The first lines of a node's process: what has to be settled before rospy is imported."""

import importlib
import sys
from typing import Dict, Optional, cast


def main(node: str) -> None:
    """Run the ``main`` of a node's module.

    The messages of ROS import numpy wherever it is installed, only to take its
    numbers as well as Python's. A node that has no use for it starts some 30 ms
    sooner and is 14 MB smaller without (measured on Debian 12).

    :param node: name of the module, e.g. ``basic_comms.nodes.talker``
    """
    cast(Dict[str, Optional[object]], sys.modules).setdefault("numpy", None)
    try:
        importlib.import_module(node).main()
    except KeyboardInterrupt:
        sys.exit(0)  # Ctrl-C before rospy took over the signal
