"""A record of a plant from a bag: its input and its output."""

import math
from typing import Dict

import rosbag

from pid_control.identification.record import IdentificationError, Record, record_of
from pid_control.recording.fields import Field, field_of, number_in
from pid_control.recording.samples import Samples, stamp_of


def read_record(
    path: str, input_name: str, output_name: str, start: float = 0.0, end: float = math.inf
) -> Record:
    """Read a record from a bag.

    Outputs have their own time stamps if present, see :meth:`.Samples.times`. Inputs have the time
    of recording, because their stamps may have another clock.

    :param path: the bag
    :param input_name: the plant's input, as topic and field
    :param output_name: the plant's output, as topic and field
    :param start: skip messages recorded before this time from the bag's start [s]
    :param end: skip messages recorded after this time from the bag's start [s]
    :raises IdentificationError: if the bag does not contain a usable record
    :raises FieldError: if a field is missing
    :raises OSError: if the file cannot be read
    :raises rosbag.ROSBagException: if the file is not a bag, or is damaged
    """
    with rosbag.Bag(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        fields = [field_of(name, topics) for name in (input_name, output_name)]
        samples: Dict[Field, Samples] = {field: Samples() for field in fields}
        begin = bag.get_start_time()
        for topic, message, stamp in bag.read_messages(topics=[one.topic for one in fields]):
            time = stamp.to_sec() - begin
            if not start <= time <= end:
                continue
            for field in samples:
                if field.topic == topic:
                    samples[field].add(time, stamp_of(message), number_in(message, field))
    inputs, outputs = (samples[field] for field in fields)
    if not outputs.values:
        raise IdentificationError(f"{fields[1]} is not in this part of the bag")
    return record_of(inputs.arrivals, inputs.values, outputs.times(), outputs.values)
