"""The command ``rosrun topic_scope mask.py``."""
