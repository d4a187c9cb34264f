"""Name and limits of a robot."""

from nodekit import BoolParameter, FloatParameter, ListParameter, ParameterSet, StringParameter


def _topics(what: str) -> ListParameter:
    return ListParameter([], element=StringParameter("", help="a topic"), help=what)


class RobotParameters(ParameterSet):
    """Parameters that all nodes of a robot have; ``config/robot_config.yaml`` sets each of them."""

    robot_name = StringParameter("default_robot", help="name of the robot")
    max_velocity = FloatParameter(
        1.0, minimum=0.0, maximum=100.0, unit="m/s", help="how fast the robot may go"
    )
    safety_mode = BoolParameter(True, help="whether the robot keeps to max_velocity")
    sensor_topics = _topics("topics that its sensors publish")
    control_topics = _topics("topics that its motors subscribe to")
