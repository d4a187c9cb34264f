"""Serial and TCP ports."""
