"""The commands ``rosrun topic_scope mask.py``, ``plot_bag.py`` and ``fetch_rosbags.py``."""
