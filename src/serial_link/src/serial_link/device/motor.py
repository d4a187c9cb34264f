"""Motor of a simulated board, with driver and encoder."""

import math

from first_order_sys_sim.first_order_plant import FirstOrderPlant, PlantSettings

#: Steps of the pulse width: 8 bits, as in Arduino's analogWrite.
PWM_STEPS = 255
#: Step of the trapezoidal integration of the angle [s], and the most steps per call; longer calls
#: use longer steps.
_STEP_S, _MOST_STEPS = 0.001, 1000


class Motor:
    """Motor with a driver (pulse width and direction) and an encoder.

    Time is an argument [s], and never decreases.

    :param settings: of the motor; its dead zone is the driver's
    :param counts_per_turn: of the encoder
    :param began_at: start time, at rest [s]
    """

    def __init__(
        self, settings: PlantSettings, counts_per_turn: int, began_at: float = 0.0
    ) -> None:
        self._plant = FirstOrderPlant(settings)
        self._counts_per_radian = counts_per_turn / (2.0 * math.pi)
        self._now = began_at
        self._angle = self._speed = 0.0
        self._zero = 0
        #: Current pulse width, from -255 to 255.
        self.pwm = 0

    def drive(self, now: float, share: float) -> None:
        """Set the pulse width.

        :param now: the time [s]
        :param share: of the full voltage, signed; limited to -1 … 1
        """
        self._advance(now)
        self.pwm = round(max(-1.0, min(1.0, share)) * PWM_STEPS)
        self._plant.hold(now, self.pwm / PWM_STEPS)

    def change(self, now: float, settings: PlantSettings) -> None:
        """Change the settings of the motor."""
        self._advance(now)
        self._plant.change(now, settings)

    def counts(self, now: float) -> int:
        """Return the encoder's count, signed."""
        self._advance(now)
        return math.floor(self._angle * self._counts_per_radian) - self._zero

    def zero(self, now: float) -> None:
        """Reset the encoder's count to 0."""
        self._zero += self.counts(now)

    def speed_of(self, counts: int, seconds: float) -> float:
        """Return the speed for a difference of counts [rad/s], quantised to one count.

        :param counts: the difference
        :param seconds: time between the two readings
        """
        return counts / self._counts_per_radian / seconds

    def _advance(self, now: float) -> None:
        steps = min(max(1, math.ceil((now - self._now) / _STEP_S)), _MOST_STEPS)
        step = max(0.0, now - self._now) / steps
        for number in range(1, steps + 1):
            speed = self._plant.output(self._now + number * step)
            self._angle += 0.5 * (self._speed + speed) * step
            self._speed = speed
        self._now = max(now, self._now)
