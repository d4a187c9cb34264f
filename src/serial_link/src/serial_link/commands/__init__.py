"""Commands for rosrun, besides the nodes."""
