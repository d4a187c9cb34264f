"""State of one page, and the messages for it."""
