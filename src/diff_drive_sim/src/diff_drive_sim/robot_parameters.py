# Pure: knows no ROS.
"""Parameters of a robot; their defaults are those of a TurtleBot3 Burger."""

from diff_drive_sim.simulation.kinematics import Pose
from diff_drive_sim.simulation.limits import RobotSettings
from diff_drive_sim.simulation.world import World
from nodekit import (
    BoolParameter,
    EnumParameter,
    FloatParameter,
    IntParameter,
    ListParameter,
    ParameterSet,
    RateParameter,
    StringParameter,
)

#: Source of the commands, which determines their type, as in the controllers.
RVIZ, GAZEBO = "rviz", "gazebo"

_LENGTH = FloatParameter(0.0, minimum=-1e6, maximum=1e6, unit="m", help="")


class RobotParameters(ParameterSet):
    """Geometry, initial pose and messages of a robot; all can be changed at run time."""

    controller_type = EnumParameter(
        RVIZ,
        choices=(RVIZ, GAZEBO),
        help="type of the commands: geometry_msgs/Twist for rviz, TwistStamped for gazebo",
    )
    publish_rate = RateParameter(
        30.0, maximum=1000.0, help="publishing rate of odometry and joint states"
    )
    wheel_separation = FloatParameter(
        0.160, minimum=0.01, maximum=100.0, unit="m", help="distance between the wheels"
    )
    wheel_radius = FloatParameter(
        0.033, minimum=0.001, maximum=100.0, unit="m", help="radius of the wheels"
    )
    robot_radius = FloatParameter(
        0.105,
        minimum=0.01,
        maximum=100.0,
        unit="m",
        help="radius of the circle for collisions with walls",
    )
    max_linear_velocity = FloatParameter(
        0.22, above=0.0, maximum=100.0, unit="m/s", help="highest speed, forward or backward"
    )
    max_angular_velocity = FloatParameter(
        2.84, above=0.0, maximum=1000.0, unit="rad/s", help="highest turning rate"
    )
    max_wheel_speed = FloatParameter(
        8.06, above=0.0, maximum=10000.0, unit="rad/s", help="highest speed of a wheel"
    )
    max_wheel_acceleration = FloatParameter(
        0.0,
        minimum=0.0,
        maximum=1e5,
        unit="rad/s^2",
        help="largest acceleration of a wheel; 0 for no limit",
    )
    command_timeout = FloatParameter(
        1.0, minimum=0.0, maximum=1e6, unit="s", help="timeout of a command; 0 for unlimited"
    )
    initial_x = FloatParameter(
        0.0, minimum=-1e6, maximum=1e6, unit="m", help="initial x, also after ~reset"
    )
    initial_y = FloatParameter(
        0.0, minimum=-1e6, maximum=1e6, unit="m", help="initial y, also after ~reset"
    )
    initial_theta = FloatParameter(
        0.0, minimum=-10.0, maximum=10.0, unit="rad", help="initial heading, 0 along x"
    )
    odometry_noise = FloatParameter(
        0.0,
        minimum=0.0,
        maximum=1.0,
        unit="m",
        help="standard deviation of the error of a wheel's path after 1 m; 0 for no error",
    )
    seed = IntParameter(0, minimum=0, help="seed of the noise; ~reset starts its sequence again")
    frame_prefix = StringParameter("", help="prefix of the names of all frames")
    publish_tf = BoolParameter(True, help="whether odom to base_footprint is published on /tf")
    scan_rate = RateParameter(
        0.0, pausable=True, maximum=100.0, help="rate of the laser scans; 0 for none"
    )
    scan_rays = IntParameter(360, minimum=1, maximum=10000, help="number of rays in a scan")
    scan_range = FloatParameter(
        3.5, above=0.0, maximum=1000.0, unit="m", help="maximum range of the laser"
    )
    laser_x = FloatParameter(
        -0.032,
        minimum=-10.0,
        maximum=10.0,
        unit="m",
        help="distance of the laser ahead of the axle",
    )
    walls = ListParameter(
        (),
        element=ListParameter((0.0,) * 4, element=_LENGTH, min_length=4, max_length=4, help=""),
        unit="m",
        help="walls: x and y of the start, x and y of the end of each",
    )
    boxes = ListParameter(
        (),
        element=ListParameter((0.0,) * 5, element=_LENGTH, min_length=5, max_length=5, help=""),
        unit="m",
        help="boxes: x and y of the centre, length, width and heading (rad) of each",
    )

    @property
    def robot(self) -> RobotSettings:
        """Geometry and limits of the robot."""
        return RobotSettings(*(getattr(self, name) for name in RobotSettings._fields))

    @property
    def initial_pose(self) -> Pose:
        """Initial pose."""
        return Pose(self.initial_x, self.initial_y, self.initial_theta)

    @property
    def world(self) -> World:
        """Walls and boxes around the robot."""
        return World(self.walls, self.boxes)
