"""The graph of nodes and topics, as the master knows it."""
