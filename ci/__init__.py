"""The project's own tests, checks, measurements and releases, a folder for each subject."""
