"""Simulated board: a device behind a serial line, on a pseudo terminal or a TCP port."""
