"""Judge's node beside a real plant: sends set points, logs the loop's topics, stops the plant."""

import threading
import time
from typing import Callable, Dict, List

import rospy

from nodekit import init_node
from nodekit.master import MasterClient, MasterUnreachable
from pid_control.judging.plant_log import PlantLog
from pid_control.msg import motor_input, motor_output, set_point
from pid_control.programs.deferred_signals import deferred_signals

#: Name of the node.
NAME = "judge"
_CLASSES = {"motor_input": motor_input, "motor_output": motor_output, "set_point": set_point}
#: Longest silence of the plant [s]: shorter than a step of a scenario.
_SILENCE_S = 0.8
#: Longest time between two set points [s] after which received outputs are up to date.
_HELD_UP_S = 0.4
#: Timeout for the plant's first output and standstill [s], and interval of the checks [s].
_STOP_S, _CHECK_S = 5.0, 0.01
#: Speed below which the plant counts as stopped [rad/s]: encoders are coarse.
_STANDS = 0.5


class PlantError(Exception):
    """Error of a plant that cannot be used for judging; the text gives the reason."""


class RealPlant:
    """Node that publishes ``set_point``, logs the loop's topics, and stops the plant.

    It publishes ``motor_input`` only while no controller runs, and only 0. Create it once per
    process.

    :raises PlantError: if the plant is missing, or another node drives it
    """

    def __init__(self) -> None:
        _check_graph()
        node = init_node(NAME)
        self._lock = threading.Lock()
        self._began = time.monotonic()
        self._log = PlantLog([], [])
        self._input = self._speed = 0.0
        self._heard_at = self._sent_at = -_SILENCE_S
        self._is_shut_down = False
        self._end_controller: Callable[[], None] = lambda: None
        self._topic = node.resolve("motor_output")
        self._set_points = node.create_publisher("set_point", set_point)
        self._drive = node.create_publisher("motor_input", motor_input)
        self._answers = node.create_subscription("motor_input", motor_input, self._on_input)
        node.create_subscription("motor_output", motor_output, self._on_output, finite=True)
        node.on_shutdown(self._shut_down)
        node.start()

    def close(self) -> None:
        """Stop the plant once more, and shut the node down for good."""
        with deferred_signals():
            self._rest()
            rospy.signal_shutdown("the judgement is complete")

    def on_shutdown(self, end_controller: Callable[[], None]) -> None:
        """Set the function that ends the controller if the node is shut down, as by rosnode kill.

        :param end_controller: ends the controller, if one runs; called in another thread
        """
        self._end_controller = end_controller

    def send_set_point(self, speed: float) -> None:
        """Publish a set point.

        :param speed: the speed [rad/s]
        :raises PlantError: if the plant is silent, or the node was shut down
        """
        self.check_node()
        now = time.monotonic()
        self._set_points.publish(set_point(speed, now - self._began))
        if now - self._sent_at > _HELD_UP_S:
            # A busy machine has held up this process: it receives the outputs of that time next.
            self._heard_at = now
        self._sent_at = now
        if now - self._heard_at > _SILENCE_S:
            raise PlantError(f"the plant is silent: nothing on {self._topic} for {_SILENCE_S:g} s")

    def stop(self) -> None:
        """Publish a set point of 0 and an input of 0."""
        self._set_points.publish(set_point(0.0, time.monotonic() - self._began))
        self._drive.publish(motor_input(0.0, 0.0))

    def wait_until_it_stands(self) -> None:
        """Stop the plant, and wait until it is at rest.

        :raises PlantError: if it does not stop, is silent, or the node was shut down
        """
        end = time.monotonic() + _STOP_S
        while True:
            self.check_node()
            self.stop()
            now = time.monotonic()
            is_heard = now - self._heard_at <= _SILENCE_S
            if is_heard and abs(self._speed) <= _STANDS:
                return
            if now > end and is_heard:
                raise PlantError(f"the input is 0, and the plant turns at {self._speed:.3g} rad/s")
            if now > end:
                raise PlantError(f"the plant is silent: nothing on {self._topic}")
            time.sleep(_CHECK_S)

    def connections(self) -> Dict[str, int]:
        """Return the numbers of the set point's subscribers and of the input's publishers."""
        return {
            "set_point": self._set_points.get_num_connections(),
            "motor_input": self._answers.get_num_connections(),
        }

    def check_alone(self) -> None:
        """Check that the controller did not start its own plant or set point.

        :raises PlantError: if another node publishes their topics
        """
        try:
            with MasterClient(rospy.get_name()) as master:
                publishers = dict(master.system_state().publishers)
        except MasterUnreachable as error:
            raise PlantError(str(error)) from None
        for topic in (self._topic, self._set_points.resolved_name):
            several = publishers.get(topic, [])
            if len(several) > 1:
                raise PlantError(f"{' and '.join(several)} publish {topic}; stop all but one")

    def check_node(self) -> None:
        """Check that the node is running.

        :raises PlantError: if it was shut down
        """
        if self._is_shut_down:
            raise PlantError("the node was shut down")

    def pop_log(self) -> PlantLog:
        """Return the log since the previous call, and clear it."""
        with self._lock:
            log, self._log = self._log, PlantLog([], [])
        return log

    def _shut_down(self) -> None:
        # While the publishers still work: afterwards the plant could not be stopped.
        self._is_shut_down = True
        self._end_controller()
        self._rest()

    def _rest(self) -> None:
        time.sleep(_CHECK_S)  # the last message of a killed controller may still arrive
        self.stop()

    def _on_input(self, message: motor_input) -> None:
        with self._lock:
            self._input = message.input
            self._log.inputs.append((time.monotonic(), message.input))

    def _on_output(self, message: motor_output) -> None:
        with self._lock:
            self._heard_at, self._speed = time.monotonic(), message.output
            self._log.outputs.append((self._heard_at, message.output, self._input))


def _check_graph() -> None:
    """Check that a plant is running, and that no other node drives it.

    :raises PlantError: if not, or if the master does not answer
    """
    topics = {name: rospy.resolve_name(name) for name in _CLASSES}
    try:
        with MasterClient("/" + NAME) as master:
            simulates_time = master.read(["/use_sim_time"]).values["/use_sim_time"] is True
            types, state = master.topic_types(), master.system_state()
    except MasterUnreachable as error:
        raise PlantError(f"a real plant needs your own master: {error}") from None
    if simulates_time:
        raise PlantError("/use_sim_time is true: a real plant uses the machine's clock")
    for name, topic in topics.items():
        if types.get(topic, _CLASSES[name]._type) not in (_CLASSES[name]._type, "*"):
            raise PlantError(f"{topic} has {types[topic]}, not {_CLASSES[name]._type}")
    publishers, subscribers = dict(state.publishers), dict(state.subscribers)
    if not publishers.get(topics["motor_output"]):
        raise PlantError(f"no plant found: {topics['motor_output']} has no publisher")
    if not subscribers.get(topics["motor_input"]):
        raise PlantError(f"no plant found: {topics['motor_input']} has no subscriber")
    for name in ("set_point", "motor_input"):
        others: List[str] = publishers.get(topics[name], [])
        if others:
            names = " and ".join(others)
            raise PlantError(f"{topics[name]}: published by another node ({names}); stop it first")
