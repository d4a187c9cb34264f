"""Robot view from above, and driving of robots."""
