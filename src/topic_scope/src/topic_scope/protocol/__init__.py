"""What the page may ask for, and how a request is judged."""
