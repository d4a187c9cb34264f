"""The Python environment that has both, and how a process enters it."""
