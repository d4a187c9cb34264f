"""Names and descriptions of the benchmark's rows; needs neither ROS nor a build."""

#: The rows of ci/bench without arguments.
MAIN = {
    "latency-1khz": "generator -> process -> observer at 1 kHz",
    "latency-100hz": "the same at 100 Hz",
    "loop": "motor -> controller -> motor at 1 kHz",
    "robot": "a robot and its controller, in one process and in two",
    "launch": "roslaunch to the first answer",
    "memory": "resident memory of a node",
    "parameters": "effect of setting a parameter",
    "bridge": "a message at 1 kHz from one ROS to the other",
}
#: The rows that --all adds.
EXTRA = {
    "executor": "a call by an executor",
    "overlap": "which callbacks overlap in executors, as in rclpy",
    "lifecycle": "behaviour of managed nodes, as in rclpy",
    "bridge-load": "4000 messages a second, and a hundred topics at 50 Hz",
    "bridge-actions": "goals of actions from one ROS to the other",
    "bridge-images": "messages of 6.2 MB at 30 Hz from one ROS to the other",
    "serial": "a board's messages through serial_link and rosserial_python",
    "images": "large messages at 30 Hz, through shared memory and by the peers",
}

if __name__ == "__main__":
    for rows, remark in ((MAIN, ""), (EXTRA, " (--all)")):
        for name, text in rows.items():
            print(f"  {name:15} {text}{remark}")
