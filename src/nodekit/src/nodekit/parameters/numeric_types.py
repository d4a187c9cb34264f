"""Numeric types of parameters: in a range, in steps, a rate.

Coercion follows the expectations of ``rosparam`` users: a float parameter accepts integers and
text such as ``1e3``, which YAML does not read as a number. Booleans and numbers that are not
finite are rejected.
"""

import math
import numbers
from typing import Any, ClassVar, Optional

from nodekit.parameters.parameter_types import Parameter, Value, format_value

#: XML-RPC, and so the parameter server, carries integers of 32 bits.
INT32_MIN, INT32_MAX = -(2**31), 2**31 - 1
#: Lowest rate other than 0 (once in eleven days), and highest default limit [Hz].
SLOWEST_HZ, FASTEST_HZ = 1e-6, 10000.0


class _NumberParameter(Parameter[Value]):
    """Finite number in a range whose ends are closed or open.

    :param minimum: smallest allowed value (closed end)
    :param maximum: largest allowed value (closed end)
    :param above: bound below the allowed values (open end)
    :param below: bound above the allowed values (open end)
    :param step: distance between allowed values, counted from the lower bound, or from 0 without a
        lower bound
    """

    noun: ClassVar[str] = ""

    def __init__(
        self,
        default: Value,
        *,
        minimum: Optional[float] = None,
        maximum: Optional[float] = None,
        above: Optional[float] = None,
        below: Optional[float] = None,
        step: Optional[float] = None,
        unit: str = "",
        help: str,
    ) -> None:
        super().__init__(default, unit=unit, help=help)
        self.minimum, self.maximum = minimum, maximum
        self.above, self.below = above, below
        self.step = step
        bounds = {"minimum": minimum, "maximum": maximum, "above": above, "below": below}
        for name, bound in bounds.items():
            if bound is not None and (not _is_number(bound) or math.isnan(bound)):
                raise ValueError(f"{name}: refused {format_value(bound)}: must be a number")
        if step is not None and not (_is_number(step) and 0.0 < step < math.inf):
            raise ValueError(f"step: refused {format_value(step)}: must be a number above 0")

    @property
    def allowed(self) -> str:
        text = f"{self.noun} in {self.range}" if self.range else self.noun
        if self.step is not None:
            text += f" in steps of {format_value(self.step)}"
        return f"{text} ({self.unit})" if self.unit else text

    @property
    def range(self) -> str:
        if (self.minimum, self.maximum, self.above, self.below) == (None,) * 4:
            return ""
        low = f"[{format_value(self.minimum)}" if self.minimum is not None else "(-inf"
        high = f"{format_value(self.maximum)}]" if self.maximum is not None else "inf)"
        if self.above is not None:
            low = f"({format_value(self.above)}"
        if self.below is not None:
            high = f"{format_value(self.below)})"
        return f"{low}, {high}"

    def _in_range(self, number: float) -> bool:
        return (
            (self.minimum is None or number >= self.minimum)
            and (self.maximum is None or number <= self.maximum)
            and (self.above is None or number > self.above)
            and (self.below is None or number < self.below)
            and (self.step is None or self._on_step(number, self.step))
        )

    def _on_step(self, number: float, step: float) -> bool:
        start = self.minimum if self.minimum is not None else self.above or 0.0
        steps = (number - start) / step
        # Tolerance for rounding, also if the step is much smaller than the number.
        return math.isclose(steps, round(steps), rel_tol=1e-13, abs_tol=1e-9)


class FloatParameter(_NumberParameter[float]):
    """Finite number; integers and numeric text such as ``1e3`` are accepted too."""

    type_name = "float"
    noun = "a number"

    def coerce(self, raw: Any) -> float:
        number = _finite_number(raw)
        if number is None or not self._in_range(number):
            raise self.refuse(raw)
        return number


class RateParameter(FloatParameter):
    """Rate in Hz.

    :param default: default rate [Hz]
    :param pausable: whether 0, for never, is allowed
    :param maximum: highest allowed rate [Hz]
    """

    def __init__(
        self, default: float, *, pausable: bool = False, maximum: float = FASTEST_HZ, help: str
    ) -> None:
        minimum = 0.0 if pausable else SLOWEST_HZ
        super().__init__(default, minimum=minimum, maximum=maximum, unit="Hz", help=help)


class IntParameter(_NumberParameter[int]):
    """Integer of 32 bits; ``5.0`` and numeric text are accepted too."""

    type_name = "int"
    noun = "a whole number"

    def __init__(self, default: int, **options: Any) -> None:
        if "above" not in options:
            options.setdefault("minimum", INT32_MIN)
        if "below" not in options:
            options.setdefault("maximum", INT32_MAX)
        super().__init__(default, **options)

    def coerce(self, raw: Any) -> int:
        number = _finite_number(raw)
        if number is None or not number.is_integer() or not self._in_range(number):
            raise self.refuse(raw)
        return int(number)


def _is_number(bound: object) -> bool:
    return isinstance(bound, numbers.Real) and not isinstance(bound, bool)


def _finite_number(raw: Any) -> Optional[float]:
    """Return a raw value as a number, None for any other value."""
    if isinstance(raw, bool) or not isinstance(raw, (numbers.Real, str)):
        return None
    try:
        number = float(raw)
    except (ValueError, OverflowError):
        return None
    return number if math.isfinite(number) else None
