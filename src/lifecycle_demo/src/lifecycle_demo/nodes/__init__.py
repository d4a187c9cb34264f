"""The demos, a node each."""
