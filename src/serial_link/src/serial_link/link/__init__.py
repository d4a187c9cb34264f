"""A board at a port: threads that read and write, and the contact with it."""
