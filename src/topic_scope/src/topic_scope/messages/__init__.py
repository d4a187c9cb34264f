"""Definitions, fields, values and stamps of messages."""
