# Pure: knows no ROS.
"""Health of the running bridge: rates and faults of its topics, and reports."""
