"""Motor in a closed loop, and tools that judge, identify and tune."""
