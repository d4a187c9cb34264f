"""The commands ``rosrun pid_control judge``, ``judge_signals``, ``identify`` and ``tune``."""
