"""What a motor says of itself on the topic motor_state."""

#: Not yet enabled since it started.
WAITING = "waiting"
ENABLED = "enabled"
#: Stopped by a request.
DISABLED = "disabled"
