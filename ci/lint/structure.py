"""Allowed imports between packages, and the folders of each package in import order.

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
        "its set point uses the signal generator's signals; it does not need the course's nodes",
    ),
    "pid_control": (
        "nodekit, pid_control_msgs, first_order_sys_sim, basic_comms.signals",
        "its motor wraps the plant, its set point uses the same signals",
    ),
    "serial_link": (
        "nodekit, first_order_sys_sim",
        "its simulated board has a motor; a board names its message types",
    ),
    "diff_drive_sim": ("nodekit", ""),
    "topic_scope": (
        "nodekit, nodekit_msgs, lifecycle_msgs",
        "it shows any graph, and uses `~change` and `ChangeState`",
    ),
    "lifecycle_demo": (
        "nodekit, lifecycle_msgs",
        "its nodes are nodekit's managed nodes; one requests its own transitions",
    ),
    "lifecycle_manager": (
        "nodekit, nodekit_msgs, lifecycle_msgs",
        "it offers `ManageNodes`, and uses `ChangeState`",
    ),
    "executors_demo": ("nodekit", ""),
    "parameters_demo": ("nodekit, parameters_demo_msgs", ""),
    "launch_files_demo": (
        "nodekit, parameters_demo.messages, parameters_demo.picture, parameters_demo.room, "
        "parameters_demo.sensors",
        "both have the same sensors, room and test card; it does not need the other's nodes",
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
#: The subject of each folder of a package with many.
SUBJECTS: Dict[str, Dict[str, str]] = {
    "nodekit": {
        "process_context": "state of the process that its nodes share",
        "shadowed_modules": "check for files beside a script that hide modules of Python or ROS",
        "package_version": "version of a package, with its commit",
        "deprecated": "old names of the public API, with warnings",
        "entry_point": "start of a script before rospy is imported, and its end",
        "argument_checks": "checks of arguments of nodekit's methods, at the line of the call",
        "throttle": "rate limit of log lines, per instance and key",
        "round_robin": "round robin over many items",
        "message_definitions": "parser of message definitions",
        "lifecycle_states": "the states of a managed node, and its transitions",
        "actions": "states of goals, and a server's list of goals",
        "parameters": "declaration, validation, reconciliation and description of parameters",
        "transport": "delivery to subscribers that may not read, and service calls",
        "shared_memory": "shared memory for large messages between processes of one user",
        "master_process": "process of a master on a free port, for tests and the judge",
        "master": "client of the master and of its parameter server",
        "rospy_internals": "uses of rospy's private interfaces, and patches, applied by `run` only",
        "timing": "clocks, and timers without drift",
        "messaging": "publishers, subscriptions, services, rate-limited log",
        "parameter_server": "watcher of the server, live parameters, `~describe`, `~change`",
        "service_hint": "hint for a command about a node without the required service",
        "groups": "callback groups, and the ready queue of an executor",
        "node": "Node and NodeScope: names, topics, timers, clients, ownership, order of opening",
        "executors": "executors with one thread or many",
        "managed": "managed nodes",
        "process": "`run` and `host`",
        "doctor": "checks of a ROS system: workspace, machine, master, nodes, topics",
        "commands": "`rosrun nodekit describe`, `change`, `callbacks`, `lifecycle`, `host`, `new`,"
        " `doctor`",
        "testing": "helpers for tests of nodes; installed",
    },
    "topic_scope": {
        "timing": "clocks of time stamps, their offsets, and implausible stamps",
        "messages": "definitions, fields, values and stamps of messages, installed or not",
        "analysis": "computations on samples: bins, measurements, spectra",
        "images": "image messages as files that a browser shows",
        "formulas": "traces computed by an expression: parser, checks, evaluation",
        "sampling": "recording of samples from topics",
        "bag": "samples from bags: player, plots, CSV files",
        "masks": "mask test: limits around a reference trace",
        "protocol": "the page's requests, and their validation",
        "page": "samples shown by one page",
        "graph": "nodes and topics, as the master lists them",
        "controls": "parameters, services and states of other nodes",
        "robots": "robot view from above, and driving",
        "commands": "`mask` and `plot_bag`, from the command line",
        "web": "the web server, and its data sources: a live graph or a bag",
        "nodes": "the node",
    },
    "ros2_bridge": {
        "rules": "rules of what is bridged: names, directions, lifetimes, exclusions",
        "health": "rates and faults of topics, and reports of them",
        "actions": "goals of either ROS: states, ids, cancellations, replies to other clients",
        "types": "types of either ROS, matched and translated",
        "environment": "the Python environment with both ROSes, and its activation",
        "ros1": "the side in ROS 1",
        "ros2": "the side in ROS 2",
        "topics": "bridged topics",
        "services": "bridged services",
        "action_bridge": "bridged actions",
        "parameters": "bridged parameters",
        "node_bridge": "nodes with their parameters",
        "diagnostics": "health of the bridge on `/diagnostics`",
        "graph_loop": "the loop that polls both graphs and updates all parts",
        "commands": "`make_environment` and `report`, from the command line",
        "nodes": "the node",
    },
}
#: The subjects of the folders of the oscilloscope's page.
PAGE: Dict[str, str] = {
    "base": "elements, numbers, times, names, keys, pointers, and the connection",
    "state": "the user's choices, and the shown samples",
    "plot": "the plots: axes, lines, zoom",
    "measure": "cursors, trigger, measurements, and export as a picture",
    "choose": "choice of traces, and their settings",
    "controls": "parameters, services and states of other nodes",
    "graph": "nodes and topics, drawn",
    "robots": "robots seen from above, and driven",
    "page": "the whole page: bars, keys, set-up, and requests to the server",
}
#: The folders of each library: each imports only earlier ones.
ROOMS: Dict[str, List[str]] = {
    **{package: list(subjects) for package, subjects in SUBJECTS.items()},
    "basic_comms": "signals conditioning message_scope nodes".split(),
    "first_order_sys_sim": "first_order_plant sampled_plant system_parameters nodes".split(),
    "motor_control": "enable_sequence motor_enabler motor_parameters nodes".split(),
    "pid_control": (
        "plant controller charts verdicts judging signal_judging identification tuning recording "
        "course_names set_point_parameters output_files programs runner signal_runner commands "
        "nodes"
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
#: Folders that must not import each other, whatever their order.
INDEPENDENT: Dict[str, List[Set[str]]] = {
    "ros2_bridge": [{"ros1", "ros2"}, {"topics", "services", "action_bridge", "parameters"}],
    "serial_link": [{"device", "host"}, {"hardware", "board"}],
}
