# Pure: knows no ROS.
"""Traces computed from others by a formula: its lexer, parser and evaluation."""
