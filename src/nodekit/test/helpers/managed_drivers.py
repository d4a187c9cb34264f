#!/usr/bin/env python3
"""Managed nodes of one process that log their callbacks, by the names on the command line.

Those called configuring and hanging hang when they are configured and shut down. One called
quitting ends the process once it is active; one called stuck does and hangs then; one called
ending ends it when configured.
"""

import sys
import time

import rospy
from roscpp.srv import GetLoggers, GetLoggersRequest

from nodekit import ManagedNode, Node, NodeScope, abort, host
from nodekit.managed import lifecycle_services


class Driver(ManagedNode):
    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self.client = node.create_client(f"{rospy.get_name()}/get_loggers", GetLoggers)
        node.on_shutdown(self.notice_end)

    def say(self, text: str) -> None:
        sys.stdout.write(f"{self.node.name[1:]} {text}\n")  # in one go: others say something too
        sys.stdout.flush()

    def notice_end(self) -> None:
        self.say(f"ends with {len(self.client.call(GetLoggersRequest(), 30.0).loggers) > 0}")

    def on_configure(self, scope: NodeScope) -> None:
        self.say("configures")
        if self.node.name == "/configuring":
            time.sleep(60.0)
        if self.node.name == "/ending":
            rospy.signal_shutdown("it ends")

    def on_activate(self, scope: NodeScope) -> None:
        if self.node.name in ("/quitting", "/stuck"):
            scope.before_deactivate(lambda: self.say("stops"))
            scope.create_timer(1.0, lambda _: abort("it cannot go on"))

    def on_shutdown(self) -> None:
        self.say(f"was {self.previous_state.label}")
        if self.node.name in ("/hanging", "/stuck"):
            time.sleep(60.0)
        self.say(f"gets {len(self.client.call(GetLoggersRequest()).loggers) > 0}")


if __name__ == "__main__":
    lifecycle_services.END_WAIT_S = 5.0  # a busy machine may need more than it has as a rule
    names = [name for name in sys.argv[1:] if ":=" not in name]
    host("drivers", [(name, "/", Driver) for name in names])
