"""Topic bridge, including the log topic."""
