"""The one place that uses interfaces of rospy that are not public.

They are alike from rospy 1.15.15 to 1.17.4. Each module is guarded: where a version of rospy
is built differently, it does without and says so, as a test with a made-up version shows; and
that this one is known is tested too.
"""
