"""A record of a running plant: drives its input, and stops it at the end."""

from typing import Any, Callable, Dict, NamedTuple, Tuple

import roslib.message
import rospy

from nodekit import Node, abort
from nodekit.master import MasterClient
from pid_control.identification.excitation import Progress, excitation
from pid_control.identification.record import IdentificationError, Record, record_of
from pid_control.recording.fields import Field, FieldError, field_of, number_in, put_number
from pid_control.recording.samples import Samples, stamp_of

#: How often the input is sent, Hz.
_SENDS_HZ = 200.0
#: How often it looks whether the plant is silent, Hz, and how long that may be, s.
_CHECKS_HZ, _SILENCE_S = 10.0, 3.0


class DriveSettings(NamedTuple):
    """How a plant is driven.

    :ivar input_name: its input, as topic and field
    :ivar output_name: its output
    :ivar least: the least input, <= 0
    :ivar largest: the largest input, > 0
    :ivar seconds: how long it is driven, s
    """

    input_name: str
    output_name: str
    least: float
    largest: float
    seconds: float


class DriveError(Exception):
    """A plant that is not to be driven, or not there; the text says why."""


class LiveExperiment:
    """Drives a plant's input and hears its output; ends the process when it has what it wants.

    It drives only what it hears. The last input is 0: at the end of the experiment, at Ctrl-C, and
    when nothing was heard of the plant for a while.

    :ROS Subscribers:
        - the output's topic, of any type

    :ROS Publishers:
        - the input's topic, of any type

    :param node: the node
    :param drive: how it is driven
    :param on_record: called with the record
    :raises DriveError: if there is no such plant, or somebody else drives it
    :raises FieldError: if a field is not there
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
            raise DriveError(f"{', '.join(others)} drives {self._input.topic}: end that first")
        self._message = input_class()
        put_number(self._message, self._input, 0.0)
        changes = excitation(drive.least, drive.largest, drive.seconds)
        self._progress = Progress(changes, drive.seconds)
        self._heard, self._sent = Samples(), Samples()
        self._heard_at, self._has_ended = rospy.get_time(), False
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
            self._give_up(str(error))
            return
        now = rospy.get_time()
        if now > 0.0:  # or /clock has not come yet
            self._heard.add(now, stamp_of(message), value)

    def _send(self, elapsed: float) -> None:
        if self._has_ended or not self._heard.values:
            return
        value = self._progress.input_at(elapsed)
        if value is None:
            self._finish()
            return
        self._publish(value)

    def _publish(self, value: float) -> None:
        put_number(self._message, self._input, value)
        stamp = self._heard.stamps[-1] if self._heard.stamps else None
        if stamp is not None and stamp_of(self._message) is not None:
            self._message.time = stamp
        self._sent.add(rospy.get_time(), None, value)
        self._publisher.publish(self._message)

    def _check_silence(self, _elapsed: float) -> None:
        if self._has_ended:
            return
        latest = self._heard.heard[-1] if self._heard.heard else self._heard_at
        if rospy.get_time() - latest > _SILENCE_S:
            self._give_up(f"nothing on {self._output.topic} for {_SILENCE_S:g} s")

    def _finish(self) -> None:
        self._stop()
        sent, heard = self._sent, self._heard
        try:
            record = record_of(sent.heard, sent.values, heard.times(), heard.values)
            self._on_record(record)
        except IdentificationError as error:
            abort(f"the record cannot tell: {error}")
        except OSError as error:
            abort(f"{error.filename}: {error.strerror}")
        else:
            rospy.signal_shutdown("the record is complete")

    def _give_up(self, why: str) -> None:
        self._stop()
        abort(why)

    def _stop(self) -> None:
        if not self._has_ended:
            self._has_ended = True
            if self._sent.values:
                self._publish(0.0)

    def _end(self) -> None:
        with self._group:  # or an input that is due just now would have the last word
            if not self._has_ended:
                self._give_up("ended before the record was complete")


def _resolve_field(node: Node, name: str, types: Dict[str, str]) -> Tuple[Field, Any]:
    """Return a field of a topic that is there, and the class of its messages."""
    whole = node.resolve(name)
    field = field_of(whole, list(types))
    message_class = roslib.message.get_message_class(types[field.topic])
    if message_class is None:
        raise DriveError(f"the messages of {field.topic}, {types[field.topic]}, are not known")
    return field, message_class
