"""Plots as SVG: pure."""
