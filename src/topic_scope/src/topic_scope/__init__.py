"""An oscilloscope in the browser for any numeric field on a ROS graph."""
