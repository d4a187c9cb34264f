#!/usr/bin/env python3
"""Subscribe to a parameter like a node and print each notification as a line [key, value].

The master notifies of every write but the subscriber's own, in order.
"""

import json
import os
import sys
from typing import Any, Tuple
from xmlrpc.client import ServerProxy
from xmlrpc.server import SimpleXMLRPCServer


def print_update(_caller_id: str, key: str, value: Any) -> Tuple[int, str, int]:
    """Take a notification of the master."""
    print(json.dumps([key.rstrip("/"), value]), flush=True)
    return 1, "", 0


def main() -> None:
    """Run until killed."""
    server = SimpleXMLRPCServer(("localhost", 0), logRequests=False)
    server.register_function(print_update, "paramUpdate")
    uri = f"http://localhost:{server.server_address[1]}/"
    master = ServerProxy(os.environ["ROS_MASTER_URI"])
    for key in sys.argv[1:]:
        master.subscribeParam(f"/spy_{os.getpid()}", uri, key)
    print(json.dumps("ready"), flush=True)
    server.serve_forever()


if __name__ == "__main__":
    main()
