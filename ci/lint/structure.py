"""Imports between packages, and the rooms of each package from the ground up.

``python3 ci lint.tables`` writes both into the pages.
"""

from typing import Dict, List, Set, Tuple

#: The packages and modules of the workspace that each package's code may import, and why.
SIBLINGS: Dict[str, Tuple[str, str]] = {
    "nodekit": ("nodekit_msgs, lifecycle_msgs", "enough for live parameters"),
    "basic_comms": ("nodekit", ""),
    "first_order_sys_sim": ("nodekit", ""),
    "motor_control": (
        "nodekit, motor_control_msgs, first_order_sys_sim, basic_comms.signals",
        "its set point makes the signal generator's signals; it needs none of the course's nodes",
    ),
    "pid_control": (
        "nodekit, pid_control_msgs, first_order_sys_sim, basic_comms.signals",
        "its motor is the plant behind messages, its set point makes the same signals",
    ),
    "serial_link": (
        "nodekit, first_order_sys_sim",
        "its simulated board has a motor; the messages are those that a board names",
    ),
    "diff_drive_sim": ("nodekit", ""),
    "topic_scope": (
        "nodekit, nodekit_msgs, lifecycle_msgs",
        "it shows any graph, changes parameters by `~change`, nodes by `ChangeState`",
    ),
    "lifecycle_demo": (
        "nodekit, lifecycle_msgs",
        "its nodes are nodekit's managed nodes; one requests its own transitions",
    ),
    "lifecycle_manager": (
        "nodekit, nodekit_msgs, lifecycle_msgs",
        "it takes commands by `ManageNodes`, changes nodes by `ChangeState`",
    ),
    "executors_demo": ("nodekit", ""),
    "parameters_demo": ("nodekit, parameters_demo_msgs", ""),
    "launch_files_demo": (
        "nodekit, parameters_demo.messages, parameters_demo.picture, parameters_demo.room, "
        "parameters_demo.sensors",
        "the sensors of both see the same room and test card; it needs none of the other's nodes",
    ),
    "my_robot_package": ("nodekit, my_robot_package_interfaces", ""),
    "robot_interfaces_demo": ("nodekit, robot_custom_interfaces", ""),
    "bot_controller_demo": (
        "nodekit, bot_controller_demo_msgs",
        "it drives any robot; only its tests need a simulator",
    ),
    "humanoid_robot_bringup": (
        "nodekit, bot_controller_demo_msgs",
        "launch files, and a script that sends the robot to a goal",
    ),
    "ros2_bridge": ("nodekit", "it reads all types but its own from their files"),
}
#: The subject of each room of a package that has many.
SUBJECTS: Dict[str, Dict[str, str]] = {
    "nodekit": {
        "shadowed_modules": "files beside a script that hide modules of Python or ROS",
        "deprecated": "old names of the public API, which warn",
        "entry_point": "the first lines of a script, before rospy is imported, and the last ones",
        "validation": "checks arguments of nodekit's methods, at the line of the call",
        "throttle": "a rate limit of log lines, one per instance and key",
        "round_robin": "takes a few of many items at a time",
        "message_definitions": "parses message definitions",
        "lifecycle_states": "the states of a managed node, and its transitions",
        "actions": "states of goals, and the list that a server keeps of them",
        "parameters": "declare, validate, reconcile, describe",
        "transport": "bytes to subscribers that may not read, and from services",
        "shared_memory": "large messages between processes of one user, in memory that both have",
        "master": "one client of the master, and of its parameter server",
        "rospy_internals": "what is not public in rospy, and the patches, which only `run` applies",
        "timing": "clocks, and timers without drift",
        "messaging": "publishers, subscriptions, services, a log for streams",
        "parameter_server": "one watcher, live parameters, `~describe`, `~change`",
        "service_hint": "what to say of a node without a service that a command needs",
        "groups": "callback groups, and the ready queue of an executor",
        "node": "Node and NodeScope: names, topics, timers, clients, ownership, order of opening",
        "executors": "executors with one thread or many; one module",
        "managed": "managed nodes",
        "process": "`run` and `host`",
        "doctor": "checks of a system: workspace, machine, master, nodes, topics",
        "commands": "`rosrun nodekit describe`, `change`, `callbacks`, `lifecycle`, `host`, `new`,"
        " `doctor`",
        "testing": "what tests of nodes need; installed",
    },
    "topic_scope": {
        "timing": "clocks of stamps, their offsets, and implausible stamps",
        "messages": "definitions, fields, values and stamps of messages, installed or not",
        "analysis": "computations on samples: bins, measurements, spectra",
        "formulas": "traces computed by formulas: lexer, parser, evaluation",
        "sampling": "records samples from topics",
        "bag": "bags: reading, playback, plots and CSV files",
        "masks": "mask tests: limits around a reference trace",
        "protocol": "the page's requests, and how they are validated",
        "page": "state of one page, and its messages",
        "graph": "graph of nodes and topics, from the master",
        "controls": "parameters, services and states of other nodes",
        "robots": "robot view from above, and driving",
        "commands": "`mask` and `plot_bag`, from the command line",
        "web": "the web server, and its data sources: a live graph or a bag",
        "nodes": "the node",
    },
    "ros2_bridge": {
        "rules": "what is bridged, under which name, which way, until when; what is not, and why",
        "actions": "goals of either ROS: states, ids, cancellations, replies to other clients",
        "types": "types of either ROS, matched and translated",
        "environment": "the Python environment that has both, and how a process enters it",
        "ros1": "the side in ROS 1",
        "ros2": "the side in ROS 2",
        "topics": "bridged topics",
        "services": "bridged services",
        "action_bridge": "bridged actions",
        "parameters": "bridged parameters",
        "node_bridge": "nodes with their parameters",
        "graph_loop": "the loop that polls both graphs and has all parts follow",
        "nodes": "the node",
    },
}
#: The same of the scripts of the oscilloscope's page.
PAGE: Dict[str, str] = {
    "base": "elements, numbers, times, names, keys, pointers, and the connection",
    "state": "what the user has chosen, and the samples that are shown",
    "plot": "the plots: axes, lines, zoom",
    "measure": "cursors, the trigger, figures, and the picture with all of them",
    "choose": "the traces, and the settings of each",
    "controls": "parameters, services and states of other nodes",
    "graph": "nodes and topics, drawn",
    "robots": "robot view from above, and driving",
    "page": "the whole page: its bars, its keys, its set-up, and its requests to the server",
}
#: The rooms of each library: each imports only those before it.
ROOMS: Dict[str, List[str]] = {
    **{package: list(subjects) for package, subjects in SUBJECTS.items()},
    "basic_comms": "signals conditioning message_scope nodes".split(),
    "first_order_sys_sim": "first_order_plant sampled_plant system_parameters nodes".split(),
    "motor_control": "enable_sequence motor_enabler motor_parameters nodes".split(),
    "pid_control": (
        "plant controller charts verdicts judging signal_judging identification tuning recording "
        "course_names set_point_parameters files programs runner signal_runner commands nodes"
    ).split(),
    "serial_link": (
        "framing negotiation device host headers port_mark hardware board link endpoints "
        "serial_parameters board_parameters commands nodes"
    ).split(),
    "my_robot_package": "robot_parameters nodes".split(),
    "humanoid_robot_bringup": "robot_control".split(),
    "lifecycle_demo": "nodes".split(),
    "parameters_demo": "picture room traffic messages sensors nodes".split(),
    "launch_files_demo": "temperature nodes".split(),
    "lifecycle_manager": (
        "plan node_state commands system reports node_client other_managers nodes"
    ).split(),
    "diff_drive_sim": "simulation robot_parameters messages nodes".split(),
    "executors_demo": ("events call_log bars picture commands demo four_timers nodes").split(),
    "robot_interfaces_demo": ("modes robot_model monitoring diagnostics commands nodes").split(),
    "bot_controller_demo": "control teleop driving nodes".split(),
}
#: Rooms that must not import each other, whatever their order.
INDEPENDENT: Dict[str, List[Set[str]]] = {
    "ros2_bridge": [{"ros1", "ros2"}, {"topics", "services", "action_bridge", "parameters"}],
    "serial_link": [{"device", "host"}, {"hardware", "board"}],
}
