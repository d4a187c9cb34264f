"""The parameters, services and states of other nodes, changed from the page."""
