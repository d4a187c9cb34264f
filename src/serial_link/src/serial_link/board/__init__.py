"""A simulated board: a device behind a line, at a pseudo terminal or a TCP port."""
