"""State of one page, and what it is sent of the samples."""
