"""How a controller is tried: it is started unchanged, and run through scenarios."""
