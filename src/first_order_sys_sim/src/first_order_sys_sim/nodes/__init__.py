"""Node of the plant."""
