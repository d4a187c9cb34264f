"""Link to a board at a port: threads that read and write, and synchronization."""
