"""From topics to samples that are kept."""
