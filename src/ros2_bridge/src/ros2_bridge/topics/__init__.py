"""Topics, with the log among them."""
