"""The web server, and what it serves: a live graph or a bag."""
