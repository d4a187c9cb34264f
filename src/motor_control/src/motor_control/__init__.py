"""A simulated DC motor, and the set point that drives it."""
