"""The commands ``rosrun pid_control judge``, ``identify`` and ``tune``."""
