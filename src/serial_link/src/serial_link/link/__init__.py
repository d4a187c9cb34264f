"""Link to a board at a port: reader and writer threads, and synchronization."""
