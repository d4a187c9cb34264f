"""Checks that no off-the-shelf linter makes."""
