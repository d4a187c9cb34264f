"""The parameter server: one client of the master, one watcher, live parameters."""
