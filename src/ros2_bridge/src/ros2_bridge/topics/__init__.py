"""Topic bridge, including the log."""
