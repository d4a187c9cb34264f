"""Graph of nodes and topics, from the master."""
