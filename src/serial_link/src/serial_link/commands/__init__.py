"""What is typed after rosrun, besides the nodes."""
