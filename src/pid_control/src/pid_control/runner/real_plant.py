"""A plant that is there already, on the master that is there: asked for speeds, and stopped."""

import threading
import time
from typing import Callable, Dict, List

import rospy

from nodekit import init_node
from nodekit.master import MasterClient, MasterUnreachable
from pid_control.judging.plant_log import PlantLog
from pid_control.msg import motor_input, motor_output, set_point
from pid_control.runner.deferred_signals import deferred_signals

#: Name of the node.
NAME = "judge"
_CLASSES = {"motor_input": motor_input, "motor_output": motor_output, "set_point": set_point}
#: Longest silence of the plant, s: less than a step of a scenario lasts.
_SILENCE_S = 0.8
#: How long the plant may take to be heard and to stand, s, and how often that is looked for.
_STOP_S, _LOOK_S = 5.0, 0.01
#: The speed below which it stands, rad/s: encoders are coarse.
_STANDS = 0.5


class PlantError(Exception):
    """Nothing can be judged with the plant; the text says why."""


class RealPlant:
    """Publishes ``set_point``, hears both topics of the loop, and stops the plant.

    It sends ``motor_input`` only where no controller is at work, and then 0. To be made once in a
    process.

    :raises PlantError: if there is no such plant, or somebody else is at work with it
    """

    def __init__(self) -> None:
        _check_graph()
        node = init_node(NAME)
        self._lock = threading.Lock()
        self._began = time.monotonic()
        self._heard = PlantLog([], [])
        self._input = self._speed = 0.0
        self._heard_at = -_SILENCE_S
        self._is_shut_down = False
        self._end_controller: Callable[[], None] = lambda: None
        self._topic = node.resolve("motor_output")
        self._wanted = node.create_publisher("set_point", set_point)
        self._drive = node.create_publisher("motor_input", motor_input)
        self._answers = node.create_subscription("motor_input", motor_input, self._on_input)
        node.create_subscription("motor_output", motor_output, self._on_output, finite=True)
        node.on_shutdown(self._shut_down)
        node.start()

    def close(self) -> None:
        """Stop the plant once more, and leave the graph; this process does not come back to it."""
        with deferred_signals():
            self._rest()
            rospy.signal_shutdown("all is judged")

    def on_shutdown(self, end_controller: Callable[[], None]) -> None:
        """Have the controller ended where the node is shut down from outside, as by rosnode kill.

        :param end_controller: ends it, if one runs; called in another thread
        """
        self._end_controller = end_controller

    def ask(self, speed: float) -> None:
        """Ask for a speed.

        :param speed: rad/s
        :raises PlantError: if the plant is silent, or the node was shut down
        """
        self.check_node()
        now = time.monotonic()
        self._wanted.publish(set_point(speed, now - self._began))
        if now - self._heard_at > _SILENCE_S:
            raise PlantError(f"the plant is silent: nothing on {self._topic} for {_SILENCE_S:g} s")

    def stop(self) -> None:
        """Ask for no speed, and give the plant an input of 0."""
        self._wanted.publish(set_point(0.0, time.monotonic() - self._began))
        self._drive.publish(motor_input(0.0, 0.0))

    def wait_until_it_stands(self) -> None:
        """Stop the plant, and wait until it stands.

        :raises PlantError: if it does not, or is silent, or the node was shut down
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
            time.sleep(_LOOK_S)

    def connections(self) -> Dict[str, int]:
        """Return how many others listen to the set point, and drive the plant."""
        return {
            "set_point": self._wanted.get_num_connections(),
            "motor_input": self._answers.get_num_connections(),
        }

    def check_alone(self) -> None:
        """Make sure that a controller has not brought a plant or a set point of its own.

        :raises PlantError: if it has
        """
        try:
            with MasterClient(rospy.get_name()) as master:
                publishers = dict(master.system_state().publishers)
        except MasterUnreachable as error:
            raise PlantError(str(error)) from None
        for topic in (self._topic, self._wanted.resolved_name):
            several = publishers.get(topic, [])
            if len(several) > 1:
                raise PlantError(f"{' and '.join(several)} publish {topic}: one is to do that")

    def check_node(self) -> None:
        """Make sure that the node is at work.

        :raises PlantError: if it was shut down
        """
        if self._is_shut_down:
            raise PlantError("the node was shut down")

    def pop_log(self) -> PlantLog:
        """Return what was heard since this was asked last."""
        with self._lock:
            heard, self._heard = self._heard, PlantLog([], [])
        return heard

    def _shut_down(self) -> None:
        # While the publishers work: afterwards nobody could stop the plant.
        self._is_shut_down = True
        self._end_controller()
        self._rest()

    def _rest(self) -> None:
        time.sleep(_LOOK_S)  # what a controller sent as it was killed may have come since
        self.stop()

    def _on_input(self, message: motor_input) -> None:
        with self._lock:
            self._input = message.input
            self._heard.inputs.append((time.monotonic(), message.input))

    def _on_output(self, message: motor_output) -> None:
        with self._lock:
            self._heard_at, self._speed = time.monotonic(), message.output
            self._heard.outputs.append((self._heard_at, message.output, self._input))


def _check_graph() -> None:
    """Make sure that there is a plant, and that nobody is at work with it.

    :raises PlantError: if that is not so, or no master is there
    """
    topics = {name: rospy.resolve_name(name) for name in _CLASSES}
    try:
        with MasterClient("/" + NAME) as master:
            simulates_time = master.read(["/use_sim_time"]).values["/use_sim_time"] is True
            types, state = master.topic_types(), master.system_state()
    except MasterUnreachable as error:
        raise PlantError(f"a real plant is on your own master: {error}") from None
    if simulates_time:
        raise PlantError("/use_sim_time is true: a real plant goes by the machine's clock")
    for name, topic in topics.items():
        if types.get(topic, _CLASSES[name]._type) not in (_CLASSES[name]._type, "*"):
            raise PlantError(f"{topic} has {types[topic]}, not {_CLASSES[name]._type}")
    publishers, subscribers = dict(state.publishers), dict(state.subscribers)
    if not publishers.get(topics["motor_output"]):
        raise PlantError(f"there is no plant: nobody publishes {topics['motor_output']}")
    if not subscribers.get(topics["motor_input"]):
        raise PlantError(f"there is no plant: nobody listens to {topics['motor_input']}")
    for name in ("set_point", "motor_input"):
        others: List[str] = publishers.get(topics[name], [])
        if others:
            raise PlantError(f"{' and '.join(others)} publishes {topics[name]}: end that first")
