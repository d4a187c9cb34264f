"""The manager, a node."""
