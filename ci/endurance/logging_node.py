#!/usr/bin/env python3
"""Managed node that writes its transitions to the file named by TRANSITION_LOG."""

import os
import time

from nodekit import ManagedNode, Node, NodeScope, run


class LoggingNode(ManagedNode):
    """Writes each step, with the machine's monotonic clock, which all processes share."""

    def __init__(self, node: Node) -> None:
        super().__init__(node)
        self.write_down("started")

    def write_down(self, what: str) -> None:
        """Write a line in one call: other processes write to the file too."""
        with open(os.environ["TRANSITION_LOG"], "ab", buffering=0) as log:
            log.write(f"{time.monotonic()} {self.node.name} {what}\n".encode())

    def on_configure(self, scope: NodeScope) -> None:
        self.write_down("configured")

    def on_activate(self, scope: NodeScope) -> None:
        self.write_down("activated")

    def on_deactivate(self) -> None:
        self.write_down("deactivated")

    def on_cleanup(self) -> None:
        self.write_down("cleaned_up")


if __name__ == "__main__":
    run("logging_node", LoggingNode)
