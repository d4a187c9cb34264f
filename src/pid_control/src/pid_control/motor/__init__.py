"""The motor: pure, with time as an argument."""
