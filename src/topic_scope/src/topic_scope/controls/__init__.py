"""Control of other nodes from the page: parameters, services and states."""
