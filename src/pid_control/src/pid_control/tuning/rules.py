"""Tuning rules that compute gains from a model of the plant.

A controller with period h adds a mean delay of h/2 to the dead time (Skogestad 2003, section 2.1):
the rules use ``theta = L + h/2``. With gain K and time constant T:

- SIMC: ``kp = T / (K (tau_c + theta))``, ``Ti = min(T, 4 (tau_c + theta))``, where the wanted time
  constant of the loop tau_c is theta unless another is given (Skogestad: Simple analytic rules for
  model reduction and PID controller tuning, Journal of Process Control 13, 2003)
- lambda: ``kp = T / (K (lambda + theta))``, ``Ti = T``, where the wanted time constant lambda is T
  unless another is given (Dahlin: Designing and tuning digital controllers, Instruments and Control
  Systems 42, 1968)
- Ziegler-Nichols, from the step response: PI ``kp = 0.9 T / (K theta)``, ``Ti = theta / 0.3``; PID
  ``kp = 1.2 T / (K theta)``, ``Ti = 2 theta``, ``Td = theta / 2`` (Ziegler, Nichols: Optimum
  settings for automatic controllers, Transactions of the ASME 64, 1942)

and ``ki = kp / Ti``, ``kd = kp Td``.
"""

from typing import Dict, NamedTuple, Optional

from pid_control.controller.pid import PI, PID
from pid_control.identification.response import Model

SIMC, LAMBDA = "simc", "lambda"
ZN_PI, ZN_PID = "ziegler-nichols-pi", "ziegler-nichols-pid"
#: Time constant of the derivative filter, as a share of the derivative time (Astrom, Murray:
#: Feedback Systems, 2nd edition, section 11.5: 2 to 20 times faster).
_FILTER = 0.1
_SOURCES = {
    SIMC: "Skogestad 2003",
    LAMBDA: "Dahlin 1968",
    ZN_PI: "Ziegler and Nichols 1942",
    ZN_PID: "Ziegler and Nichols 1942",
}
METHODS = tuple(_SOURCES)


class Gains(NamedTuple):
    """Gains of a controller.

    :ivar method: one of METHODS
    :ivar source: publication of the rule
    :ivar mode: PI or PID
    :ivar kp: output per unit of error
    :ivar ki: output per unit of error and second [1/s]
    :ivar kd: output per unit of the measurement's rate of change [s]
    :ivar filter_time: time constant of the derivative filter [s]
    """

    method: str
    source: str
    mode: str
    kp: float
    ki: float
    kd: float = 0.0
    filter_time: float = 0.0


def gains_of(model: Model, period: float, wanted: Optional[float] = None) -> Dict[str, Gains]:
    """Return the gains by each method.

    :param model: the plant
    :param period: period of the controller, > 0 [s]
    :param wanted: desired time constant of the closed loop for SIMC and lambda [s]; None for the
        default of the method
    """
    tau, theta = model.time_constant, model.dead_time + 0.5 * period
    tight = theta if wanted is None else wanted
    smooth = tau if wanted is None else wanted
    ultimate = tau / (model.gain * theta)
    return {
        SIMC: _gains(SIMC, tau / (model.gain * (tight + theta)), min(tau, 4.0 * (tight + theta))),
        LAMBDA: _gains(LAMBDA, tau / (model.gain * (smooth + theta)), tau),
        ZN_PI: _gains(ZN_PI, 0.9 * ultimate, theta / 0.3),
        ZN_PID: _gains(ZN_PID, 1.2 * ultimate, 2.0 * theta, 0.5 * theta),
    }


def _gains(method: str, kp: float, integral_time: float, derivative_time: float = 0.0) -> Gains:
    return Gains(
        method,
        _SOURCES[method],
        PID if derivative_time else PI,
        kp,
        kp / integral_time,
        kp * derivative_time,
        _FILTER * derivative_time,
    )


def as_yaml(gains: Gains, origin: str, least: float, largest: float) -> str:
    """Return gains as parameters of the node controller.

    :param gains: the gains
    :param origin: source of the model, for the comment
    :param least: lower limit of the output
    :param largest: upper limit of the output
    """
    return "\n".join(
        [
            f"# {gains.method} ({gains.source}), for {' '.join(origin.split())}.",
            f"mode: {gains.mode}",
            f"kp: {_number(gains.kp)}",
            f"ki: {_number(gains.ki)}  # 1/s",
            f"kd: {_number(gains.kd)}  # s",
            f"filter_time: {_number(gains.filter_time)}  # s",
            f"output_min: {_number(least)}",
            f"output_max: {_number(largest)}",
            "",
        ]
    )


def _number(value: float) -> str:
    """Format a number for YAML, which does not accept an exponent without a decimal point."""
    short = float(f"{value:.4g}")
    return repr(short) if short == 0.0 or abs(short) >= 1e-4 else f"{short:.12f}"
