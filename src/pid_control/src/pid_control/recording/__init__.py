"""Records of plants, from bags and from running ones."""
