"""The project's own tests, checks, measurements and releases; each folder is one subject."""
