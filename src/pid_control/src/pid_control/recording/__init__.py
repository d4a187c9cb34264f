"""Records of plants, from bags and from running plants."""
