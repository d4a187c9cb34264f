"""The commands ``rosrun pid_control identify`` and ``tune``."""
