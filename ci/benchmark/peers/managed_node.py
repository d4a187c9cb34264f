#!/usr/bin/env python3
"""A managed node without callbacks."""

from nodekit import ManagedNode, run

run("managed", ManagedNode)
