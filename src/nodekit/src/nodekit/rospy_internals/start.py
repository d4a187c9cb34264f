"""How rospy starts."""

import contextlib
import time
import types
from typing import Iterator

import rospy.impl.init

#: How often to look whether the node is registered, s.
_LOOK_EVERY_S = 0.001


@contextlib.contextmanager
def looking_often() -> Iterator[None]:
    """Start a node as soon as it is registered; ``rospy.init_node`` looks every 0.1 s only."""
    module = rospy.impl.init
    if getattr(module, "time", None) is not time:  # it waits in another way
        yield
        return
    module.time = types.SimpleNamespace(sleep=lambda s: time.sleep(min(s, _LOOK_EVERY_S)))
    try:
        yield
    finally:
        module.time = time
