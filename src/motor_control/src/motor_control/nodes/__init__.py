"""Nodes of the motor and its set point."""
