"""Programs that students hand in: found, unpacked, built, started, watched and ended."""
