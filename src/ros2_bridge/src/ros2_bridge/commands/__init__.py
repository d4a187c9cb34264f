"""Command ``make_environment``."""
