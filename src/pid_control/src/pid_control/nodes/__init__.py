"""The nodes: motor, set point generator and controller."""
