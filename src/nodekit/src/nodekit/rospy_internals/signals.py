"""How rospy hears signals of the operating system."""

import signal

import rospy.core


def register() -> None:
    """Have rospy shut the node down on SIGINT and SIGTERM, and when its terminal is closed.

    ``rospy.init_node`` does the same for the first two where it is called by the main thread.
    """
    rospy.core.register_signals()
    if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN:  # which is nohup's doing
        signal.signal(signal.SIGHUP, signal.getsignal(signal.SIGTERM))
