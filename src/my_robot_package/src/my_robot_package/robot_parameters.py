"""Name and limits of a robot."""

from nodekit import BoolParameter, FloatParameter, ListParameter, ParameterSet, StringParameter


def _topics(what: str) -> ListParameter:
    return ListParameter([], element=StringParameter("", help="a topic"), help=what)


class RobotParameters(ParameterSet):
    """Common parameters of a robot's nodes; ``config/robot_config.yaml`` sets each of them."""

    robot_name = StringParameter("default_robot", help="name of the robot")
    max_velocity = FloatParameter(
        1.0, minimum=0.0, maximum=100.0, unit="m/s", help="speed limit of the robot"
    )
    safety_mode = BoolParameter(True, help="whether max_velocity is enforced")
    sensor_topics = _topics("topics that its sensors publish")
    control_topics = _topics("topics that its motors subscribe to")
