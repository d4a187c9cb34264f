#!/usr/bin/env python3
"""Node that starts forever, with requests to the master."""

import itertools

from std_srvs.srv import Trigger, TriggerResponse

from nodekit import Node, run


def start(node: Node) -> None:
    """Register services without end."""
    print("starting", flush=True)
    for number in itertools.count():
        lifetime = node.create_scope()
        lifetime.create_service(f"~{number}", Trigger, lambda request: TriggerResponse())
        lifetime.close()


if __name__ == "__main__":
    run("slow_start", start)
