"""Experiment that drives a running plant's input and records its output."""

from typing import Any, Callable, Dict, NamedTuple, Tuple

import roslib.message
import rospy

from nodekit import Node, abort
from nodekit.master import MasterClient
from pid_control.identification.excitation import Progress, excitation
from pid_control.identification.record import IdentificationError, Record, record_of
from pid_control.recording.fields import Field, FieldError, field_of, number_in, put_number
from pid_control.recording.samples import Samples, stamp_of

#: Rate of the input messages [Hz].
_SENDS_HZ = 200.0
#: Rate of the check for a silent plant [Hz], and its timeout [s].
_CHECKS_HZ, _SILENCE_S = 10.0, 3.0


class DriveSettings(NamedTuple):
    """Settings of an experiment.

    :ivar input_name: the plant's input, as topic and field
    :ivar output_name: the plant's output, as topic and field
    :ivar least: the least input, <= 0
    :ivar largest: the largest input, > 0
    :ivar seconds: duration [s]
    """

    input_name: str
    output_name: str
    least: float
    largest: float
    seconds: float


class DriveError(Exception):
    """Error of a plant that cannot be driven; the text gives the reason."""


class LiveExperiment:
    """Node that drives a plant's input, records its output, and ends the process when complete.

    It starts to send when the first output arrives. The last input is 0: at the end of the
    experiment, at Ctrl-C, and when the plant is silent for too long.

    :ROS Subscribers:
        - the output's topic, of any type

    :ROS Publishers:
        - the input's topic, of any type

    :param node: the node
    :param drive: settings of the experiment
    :param on_record: called with the record
    :raises DriveError: if the plant cannot be driven, or another node drives it
    :raises FieldError: if a field is missing
    """

    def __init__(
        self, node: Node, drive: DriveSettings, on_record: Callable[[Record], None]
    ) -> None:
        self._drive, self._on_record = drive, on_record
        with MasterClient(node.name) as master:
            types = master.topic_types()
            publishers = dict(master.system_state().publishers)
        self._input, input_class = _resolve_field(node, drive.input_name, types)
        self._output, output_class = _resolve_field(node, drive.output_name, types)
        others = [name for name in publishers.get(self._input.topic, []) if name != node.name]
        if others:
            names = ", ".join(others)
            raise DriveError(
                f"{self._input.topic}: driven by another node ({names}); stop it first"
            )
        self._message = input_class()
        put_number(self._message, self._input, 0.0)
        if "[" not in self._output.path:  # an array is empty before the first message
            number_in(output_class(), self._output)
        changes = excitation(drive.least, drive.largest, drive.seconds)
        self._progress = Progress(changes, drive.seconds)
        self._outputs, self._inputs = Samples(), Samples()
        self._started_at, self._has_ended = rospy.get_time(), False
        self._group = node.default_group
        self._publisher = node.create_publisher(self._input.topic, input_class)
        node.create_subscription(self._output.topic, output_class, self._on_output)
        node.create_timer(_SENDS_HZ, self._send)
        node.create_timer(_CHECKS_HZ, self._check_silence, steady=True)
        node.on_shutdown(self._end)

    def _on_output(self, message: Any) -> None:
        try:
            value = number_in(message, self._output)
        except FieldError as error:
            self._abort(str(error))
            return
        now = rospy.get_time()
        if now > 0.0:  # 0 until the first message on /clock
            self._outputs.add(now, stamp_of(message), value)

    def _send(self, elapsed: float) -> None:
        if self._has_ended or not self._outputs.values:
            return
        value = self._progress.input_at(elapsed)
        if value is None:
            self._finish()
            return
        self._publish(value)

    def _publish(self, value: float) -> None:
        put_number(self._message, self._input, value)
        stamp = self._outputs.stamps[-1] if self._outputs.stamps else None
        if stamp is not None and stamp_of(self._message) is not None:
            self._message.time = stamp
        self._inputs.add(rospy.get_time(), None, value)
        self._publisher.publish(self._message)

    def _check_silence(self, _elapsed: float) -> None:
        if self._has_ended:
            return
        arrivals = self._outputs.arrivals
        latest = arrivals[-1] if arrivals else self._started_at
        if rospy.get_time() - latest > _SILENCE_S:
            self._abort(f"nothing on {self._output.topic} for {_SILENCE_S:g} s")

    def _finish(self) -> None:
        self._stop()
        inputs, outputs = self._inputs, self._outputs
        try:
            record = record_of(inputs.arrivals, inputs.values, outputs.times(), outputs.values)
            self._on_record(record)
        except IdentificationError as error:
            abort(f"record not usable: {error}")
        except OSError as error:
            abort(f"{error.filename}: {error.strerror}")
        else:
            rospy.signal_shutdown("the record is complete")

    def _abort(self, why: str) -> None:
        self._stop()
        abort(why)

    def _stop(self) -> None:
        if not self._has_ended:
            self._has_ended = True
            if self._inputs.values:
                self._publish(0.0)

    def _end(self) -> None:
        with self._group:  # so that no input in progress is sent after the 0
            if not self._has_ended:
                self._abort("ended before the record was complete")


def _resolve_field(node: Node, name: str, types: Dict[str, str]) -> Tuple[Field, Any]:
    """Return a field of an existing topic, and the class of its messages."""
    whole = node.resolve(name)
    field = field_of(whole, list(types))
    message_class = roslib.message.get_message_class(types[field.topic])
    if message_class is None:
        raise DriveError(f"{field.topic}: message type not installed ({types[field.topic]})")
    return field, message_class
