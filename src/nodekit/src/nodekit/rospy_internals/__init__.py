"""The one place that uses interfaces of rospy that are not public.

They are alike from rospy 1.15.9 to 1.17.0. Each module is guarded: where a version of rospy
is built differently, it does without and says so, and a test shows red.
"""

from nodekit.rospy_internals.logs import mend_logs
from nodekit.rospy_internals.shutdown import mend_shutdown
from nodekit.rospy_internals.subscribers import ask_for_statistics_once

ask_for_statistics_once()
mend_logs()
mend_shutdown()
