"""What keys mean, and the terminal that they come from."""
