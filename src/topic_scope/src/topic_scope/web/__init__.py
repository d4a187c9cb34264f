"""Web server, and its data sources: a live graph or a bag."""
