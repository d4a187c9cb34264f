"""Commands for rosrun that are not nodes."""
