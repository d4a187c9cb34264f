# Pure: knows no ROS.
"""Parameters of the first-order system, under the course's names."""

from first_order_sys_sim.first_order_plant import EXACT, METHODS, PlantSettings
from nodekit import EnumParameter, FloatParameter, ParameterSet, to_float32


class SystemParameters(ParameterSet):
    """Parameters of the system and its output rate; all can be changed at run time."""

    system_node_rate = FloatParameter(
        150.0, minimum=0.1, maximum=10000.0, unit="Hz", help="publishing rate of the output"
    )
    system_sample_time = FloatParameter(
        0.02,
        minimum=1e-4,
        maximum=1e3,
        unit="s",
        help="time between samples of the input, which is held",
    )
    system_param_K = FloatParameter(
        13.2, minimum=-1e6, maximum=1e6, help="gain: steady-state output per unit of input"
    )
    system_param_T = FloatParameter(
        0.05, above=0.0, maximum=1e6, unit="s", help="time constant: time for 63 % of a step"
    )
    system_initial_conditions = FloatParameter(
        0.0, minimum=-1e9, maximum=1e9, help="initial output; a change sets the output"
    )
    system_max_output = FloatParameter(
        13.0, above=0.0, maximum=1e9, help="largest magnitude of the output"
    )
    system_min_input = FloatParameter(
        0.2, minimum=0.0, maximum=1e9, help="dead zone: an input up to this magnitude acts as 0"
    )
    method = EnumParameter(
        EXACT,
        choices=METHODS,
        help="integration method; euler as in the course, for comparison",
    )

    @property
    def plant(self) -> PlantSettings:
        """Parameters of the plant."""
        return PlantSettings(
            gain=self.system_param_K,
            time_constant=self.system_param_T,
            max_output=self.system_max_output,
            # Inputs are float32, and the float32 nearest to 0.2 is greater than 0.2.
            min_input=to_float32(self.system_min_input),
            method=self.method,
        )
