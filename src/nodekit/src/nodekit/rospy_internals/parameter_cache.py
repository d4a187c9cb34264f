"""Hook into rospy's parameter cache: passes on the paramUpdate calls of the master."""

from typing import Any, Callable

import rospy.impl.paramserver


def on_push(handle: Callable[[str, Any], bool]) -> bool:
    """Call a function with each parameter update that the master sends.

    rospy drops updates of keys that it has not cached, and serves cached values in place of the
    server's. Updates are taken before they reach the cache, and the cache stays empty.

    :param handle: called with key and raw value, from a thread of rospy's XML-RPC server;
        returns whether it follows the key
    :returns: False if this rospy has no such cache; changes are then found by polling only
    """
    cache = rospy.impl.paramserver.get_param_server_cache()
    if not callable(getattr(cache, "update", None)):
        return False
    update: Callable[[str, Any], None] = cache.update

    def update_and_notify(key: str, value: Any) -> None:
        followed = handle(key, value)
        try:
            update(key, value)
        except KeyError:
            if not followed:
                raise  # rospy answers the master that it is not subscribed

    cache.update = update_and_notify
    return True


#: Parameter that rospy reads with each log line for /rosout, until it has a value that is set, and
#: to which it stays subscribed after its end.
ROSOUT_PARAMETER = "/rosout_disable_topics_generation"


def cache(key: str, value: Any) -> None:
    """Set the cached value of a parameter, until the master sends another value.

    :param key: global name of the parameter; the caller must subscribe to it
    :param value: its value, or the default if it is not set
    """
    reads = rospy.impl.paramserver.get_param_server_cache()
    if callable(getattr(reads, "set", None)):
        reads.set(key, value)
