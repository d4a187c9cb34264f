#!/usr/bin/env python3
"""A talker and a listener in one process."""

from basic_comms.nodes.listener import Listener
from basic_comms.nodes.talker import Talker
from nodekit import host

if __name__ == "__main__":
    host("hosted", [("listener", "lab", Listener), ("talker", "lab", Talker)])
