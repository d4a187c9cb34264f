"""Nodes, one module each."""
