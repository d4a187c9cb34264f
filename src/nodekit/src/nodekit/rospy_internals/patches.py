"""All that is changed in rospy for a process as a whole."""

import functools

from nodekit.rospy_internals.accepting import mend_accepting
from nodekit.rospy_internals.logs import mend_logs
from nodekit.rospy_internals.shutdown import mend_shutdown
from nodekit.rospy_internals.subscribers import ask_for_statistics_once


@functools.lru_cache(maxsize=None)
def apply() -> None:
    """Apply the patches, once in a process; before ``rospy.init_node``."""
    ask_for_statistics_once()
    mend_accepting()
    mend_logs()
    mend_shutdown()
