"""Node of the bridge."""
