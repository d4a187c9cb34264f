"""Simulated DC motor, and its set point."""
