"""What the tests of the page need: a browser without a screen, a scope, and how to await things."""
