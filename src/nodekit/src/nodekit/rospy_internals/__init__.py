"""All uses of rospy's private interfaces.

These interfaces are the same from rospy 1.15.15 to 1.17.4. Each module checks them: with another
rospy it falls back to public interfaces and logs a warning. Tests cover a changed rospy, and that
the installed rospy is recognised.
"""
