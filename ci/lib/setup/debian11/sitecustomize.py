"""Give threads back a method that Python 3.9 took away and rospy 1.15.9 calls when it ends.

Debian 11 has these two. Without it, ``rostopic echo -n 1`` and the like end with a traceback.
"""

import threading

setattr(threading.Thread, "isAlive", threading.Thread.is_alive)
