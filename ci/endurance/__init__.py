"""Long runs of the nodes under faults, with bounds."""
