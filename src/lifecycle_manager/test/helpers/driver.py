#!/usr/bin/env python3
"""A managed node that logs its transitions."""

import sys

from nodekit import ManagedNode, NodeScope, run


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


class Driver(ManagedNode):
    def on_configure(self, scope: NodeScope) -> None:
        say("configure")

    def on_activate(self, scope: NodeScope) -> None:
        say("activate")

    def on_deactivate(self) -> None:
        say("deactivate")

    def on_cleanup(self) -> None:
        say("cleanup")


if __name__ == "__main__":
    run("driver", Driver)
