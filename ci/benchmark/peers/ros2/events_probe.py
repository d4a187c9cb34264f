"""Print how often rclpy's EventsExecutor calls a timer of 1 ms within a second."""

import os
import threading
import time

import rclpy
from rclpy.experimental.events_executor import EventsExecutor

rclpy.init()
node = rclpy.create_node("probe")
calls = []
node.create_timer(0.001, lambda: calls.append(None))
executor = EventsExecutor()
executor.add_node(node)
threading.Thread(target=executor.spin, daemon=True).start()
time.sleep(1.0)
print(len(calls), flush=True)
os._exit(0)  # its thread never ends
