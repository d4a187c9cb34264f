# Pure: knows no ROS.
"""Parameters of the motor, under the course's names."""

from first_order_sys_sim.first_order_plant import PlantSettings
from nodekit import LARGEST_FLOAT32, FloatParameter, ParameterSet


class MotorParameters(ParameterSet):
    """Parameters of the motor; all may change at any sample."""

    sample_time = FloatParameter(
        0.02,
        minimum=1e-4,
        maximum=1e3,
        unit="s",
        help="sample time of the input and of the published speed",
    )
    sys_gain_K = FloatParameter(
        1.75, minimum=0.0, maximum=1e6, help="gain: steady-state speed per unit of input"
    )
    sys_tau_T = FloatParameter(
        0.5, above=0.0, maximum=1e6, unit="s", help="time constant: time for 63 % of a step"
    )
    initial_conditions = FloatParameter(
        0.0,
        minimum=-1e9,
        maximum=1e9,
        help="initial speed when the motor is enabled; a change sets the speed",
    )

    @property
    def plant(self) -> PlantSettings:
        """Parameters of the plant; its output is limited to a message's float32."""
        return PlantSettings(self.sys_gain_K, self.sys_tau_T, max_output=LARGEST_FLOAT32)
