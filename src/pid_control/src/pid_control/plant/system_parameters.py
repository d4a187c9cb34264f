"""Live parameters of the simulated motor: gain K, time constant T, limits; the course's names."""

from first_order_sys_sim.first_order_plant import PlantSettings
from nodekit import FloatParameter, ParameterSet, to_float32


class SystemParameters(ParameterSet):
    """Parameters of the motor and of its measurement, all live."""

    system_node_rate = FloatParameter(
        1000.0, minimum=0.1, maximum=10000.0, unit="Hz", help="how often the output is published"
    )
    system_sample_time = FloatParameter(
        0.002,
        minimum=1e-4,
        maximum=1e3,
        unit="s",
        help="how often the input is sampled, to be held",
    )
    system_param_K = FloatParameter(
        13.1,
        minimum=-1e6,
        maximum=1e6,
        unit="rad/s",
        help="gain: steady speed for each unit of input",
    )
    system_param_T = FloatParameter(
        0.04, above=0.0, maximum=1e6, unit="s", help="time constant: 63 % of a step pass in it"
    )
    system_initial_cond = FloatParameter(
        0.0,
        minimum=-1e9,
        maximum=1e9,
        unit="rad/s",
        help="speed at the start; a change puts the speed there",
    )
    system_max_speed = FloatParameter(
        13.0, above=0.0, maximum=1e9, unit="rad/s", help="largest magnitude of the speed"
    )
    system_min_input = FloatParameter(
        0.05, minimum=0.0, maximum=1e9, help="dead zone: an input up to this magnitude acts as 0"
    )
    system_dead_time = FloatParameter(
        0.0, minimum=0.0, maximum=1e3, unit="s", help="how long an input takes to arrive"
    )

    @property
    def plant(self) -> PlantSettings:
        """The plant's settings."""
        return PlantSettings(
            gain=self.system_param_K,
            time_constant=self.system_param_T,
            max_output=self.system_max_speed,
            # Inputs are float32, and the nearest float32 of 0.05 is greater than 0.05.
            min_input=to_float32(self.system_min_input),
        )
