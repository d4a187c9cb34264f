"""Message, service and action types of both ROSes: matched and converted."""
