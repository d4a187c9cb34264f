"""Requests of the page, and their validation."""
