#!/usr/bin/env python3
"""The workspace's own generator and process in one process. Usage: ... RECORD

The generator records when it publishes.
"""

from basic_comms.nodes.process import Process
from recorded_generator import RecordedGenerator

from nodekit import host

if __name__ == "__main__":
    members = [("signal_generator", "", RecordedGenerator), ("process", "", Process)]
    host("host", members)
