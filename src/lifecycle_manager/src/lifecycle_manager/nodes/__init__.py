"""Manager node."""
