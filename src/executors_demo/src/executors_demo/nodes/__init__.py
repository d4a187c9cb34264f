"""Demo nodes."""
