"""Debian packages, the container image, and releases."""
