"""Robots seen from above, and driven."""
