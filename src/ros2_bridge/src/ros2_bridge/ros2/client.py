"""ROS 2 service client with a timeout."""

import threading
import time
from typing import Any, Callable, Dict, List

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy

from ros2_bridge.ros2.call_window import QUEUE, CallWindow
from ros2_bridge.ros2.participant import Participant


class NoResponse(Exception):
    """A missing response of a ROS 2 service; the text names the service and the cause."""


class Ros2Client:
    """Client of one ROS 2 service; thread-safe.

    :param participant: the bridge in ROS 2
    :param cls: class of the service
    :param name: of the service
    :param depth: queue size for responses
    """

    def __init__(self, participant: Participant, cls: Any, name: str, depth: int = 10) -> None:
        self._cls, self._name = cls, name
        self._lock = threading.Lock()
        self._waiting: Dict[int, Callable[[Any], None]] = {}
        self._window = CallWindow()
        self._client, self.close = participant.create_client(cls, name, self._receive, depth)

    def is_ready(self) -> bool:
        """Return whether the service is offered."""
        try:
            return bool(self._client.service_is_ready())
        except _rclpy.InvalidHandle:
            return False

    def send(self, request: Any, receive: Callable[[Any], None]) -> int:
        """Call the service without waiting.

        :param receive: called with the response, in the loop's thread
        :returns: number of the call, for :meth:`forget`
        :raises NoResponse: if the service is not offered
        """
        try:
            if not self._client.service_is_ready():
                raise NoResponse(f"{self._name} is not offered in ROS 2")
            with self._lock:  # before a response can arrive
                number: int = self._client.handle.send_request(request)
                self._waiting[number] = receive
        except _rclpy.InvalidHandle:
            raise NoResponse(
                f"{self._name} in ROS 2: the bridge has just closed its client"
            ) from None
        return number

    def forget(self, number: int) -> None:
        """Stop waiting for a response."""
        with self._lock:
            self._waiting.pop(number, None)

    def call(self, request: Any, timeout: float) -> Any:
        """Call the service and wait for the response.

        At most as many calls are sent as a server's queue holds; the others wait.

        :param timeout: longest wait, including the wait before sending [s]
        :raises NoResponse: if the service is not offered, or does not respond in time
        """
        deadline = time.monotonic() + timeout
        turn = self._window.enter(deadline)
        if turn is None:
            raise self._no_answer(timeout)
        try:
            return self._call(request, timeout, deadline)
        finally:
            self._window.leave(turn)

    def _call(self, request: Any, timeout: float, deadline: float) -> Any:
        responses: List[Any] = []
        came = threading.Event()

        def receive(response: Any) -> None:
            responses.append(response)
            came.set()

        number = self.send(request, receive)
        if not came.wait(deadline - time.monotonic()):
            self.forget(number)
            raise self._no_answer(timeout)
        return responses[0]

    def _no_answer(self, timeout: float) -> NoResponse:
        text = f"{self._name} in ROS 2: no answer within {timeout:g} s"
        if len(self._window) >= QUEUE:
            text += (
                f"; {len(self._window)} calls are pending, and a server keeps {QUEUE} requests"
                " unless its node sets a greater depth"
            )
        return NoResponse(text)

    def _receive(self, most: int) -> None:
        for _ in range(most):
            header, response = self._client.handle.take_response(self._cls.Response)
            if header is None:
                break
            with self._lock:
                receive = self._waiting.pop(header.request_id.sequence_number, None)
            if receive is not None:
                receive(response)
