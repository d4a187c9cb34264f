"""Recording of topics' samples in memory."""
