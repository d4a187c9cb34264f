"""How rospy connects to a publisher.

Where that refuses, rospy gives the connection up after a second only, and takes it for a good one
until then: of a publisher that was just made anew, nothing would be heard for ever.
"""

from typing import Any

from rospy.exceptions import TransportInitError


def leave_where_refused(topic: Any, connection: Any) -> None:
    """Have a topic forget a connection at once that comes to nothing.

    :param topic: rospy's implementation object of the subscribed topic
    :param connection: rospy's object for the connection, not connected yet
    """
    connect = connection.connect

    def connect_or_leave(*args: Any, **kwds: Any) -> None:
        try:
            connect(*args, **kwds)
        except TransportInitError:
            topic.remove_connection(connection)
            raise

    connection.connect = connect_or_leave
