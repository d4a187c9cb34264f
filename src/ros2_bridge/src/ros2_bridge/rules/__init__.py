"""What is bridged, under which name, in which direction."""
