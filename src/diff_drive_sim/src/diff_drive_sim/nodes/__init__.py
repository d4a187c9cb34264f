"""Nodes of the robots."""
