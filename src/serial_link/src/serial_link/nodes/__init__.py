"""The nodes: the link to a board, and a simulated board."""
