"""Ports that a board may be at."""
