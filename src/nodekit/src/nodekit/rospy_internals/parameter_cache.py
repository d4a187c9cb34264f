"""How rospy takes in parameters that the master sends."""

from typing import Any, Callable

import rospy.impl.paramserver


def on_push(handle: Callable[[str, Any], bool]) -> bool:
    """Have a function called with each parameter that the master sends.

    ``rospy`` drops what it has not cached before, and what it has cached it
    serves from then on in place of the server's value. So updates are taken
    before they reach the cache, and the cache stays empty.

    :param handle: called with key and raw value, from a thread of rospy's
        XML-RPC server; tells whether the key is one that it follows
    :returns: False where this rospy has no such place; changes are then
        noticed by reading only
    """
    cache = rospy.impl.paramserver.get_param_server_cache()
    if not callable(getattr(cache, "update", None)):
        return False
    update: Callable[[str, Any], None] = cache.update

    def update_and_tell(key: str, value: Any) -> None:
        followed = handle(key, value)
        try:
            update(key, value)
        except KeyError:
            if not followed:
                raise  # rospy answers the master that it is not subscribed

    cache.update = update_and_tell
    return True


#: What rospy asks the master for with each line of the log that goes to /rosout,
#: until it has an answer that is set, and stays subscribed to after its end.
ROSOUT_PARAMETER = "/rosout_disable_topics_generation"


def cache(key: str, value: Any) -> None:
    """Answer a parameter's cached reads from now on, until the master sends another value.

    :param key: global name of the parameter, which somebody has to subscribe
    :param value: its value, or the default where it is not set
    """
    reads = rospy.impl.paramserver.get_param_server_cache()
    if callable(getattr(reads, "set", None)):
        reads.set(key, value)
