"""Call services of nodes that may not answer."""

import difflib
import sys
import threading
import time
from typing import Any, List

import rosgraph
import rospy

from nodekit.live.master import MasterClient

#: Longest wait for an answer, s.
TIMEOUT_S = 2.0


class NoAnswer(Exception):
    """A service that does not answer; the text says why."""


class Call(threading.Thread):
    """A call under way, in a thread of its own: rospy's has no time-out.

    :param service: global name of the service
    :param kind: its type
    :param arguments: of the request
    """

    def __init__(self, service: str, kind: type, *arguments: Any) -> None:
        super().__init__(daemon=True)
        self._service, self._kind, self._arguments = service, kind, arguments
        self._answer: Any = None
        self._error: object = f"no answer within {TIMEOUT_S:g} s"
        self.deadline = time.monotonic() + TIMEOUT_S
        self.start()

    def run(self) -> None:
        """Call the service."""
        try:
            self._answer = rospy.ServiceProxy(self._service, self._kind)(*self._arguments)
        except Exception as error:  # of any kind: it is told in the other thread
            self._error = error

    def is_done_by(self, deadline: float) -> bool:
        """Wait for the end of the call; tell whether it was reached.

        :param deadline: s on the monotonic clock
        """
        self.join(max(0.0, deadline - time.monotonic()))
        return not self.is_alive()

    def answer(self) -> Any:
        """Return the answer.

        :raises NoAnswer: if there is none in good time
        """
        self.is_done_by(self.deadline)
        if self._answer is None:
            raise NoAnswer(str(self._error))
        return self._answer


def master(caller: str) -> MasterClient:
    """Return a client of the master for a command.

    :param caller: name of the command
    """
    return MasterClient(rosgraph.get_master_uri(), "/" + caller, "")


def owners(client: MasterClient, service: str, namespace: str = "/") -> List[str]:
    """List the namespaces at or below one where a service is offered.

    :param client: asks the master
    :param service: base name of the service
    :param namespace: global name
    :returns: global names, sorted
    :raises MasterUnreachable: if the master does not answer
    """
    prefix, suffix = namespace.rstrip("/") + "/", "/" + service
    names = [name for name, _ in client.system_state().services if name.endswith(suffix)]
    found = [name[: -len(suffix)] for name in names]
    return sorted(owner for owner in found if (owner + "/").startswith(prefix))


def say_what_there_is(client: MasterClient, service: str, namespace: str, problem: str) -> None:
    """Tell the user that nobody offers a service there, and who does.

    :param problem: a sentence that says the first
    :raises MasterUnreachable: if the master does not answer
    """
    everyone = owners(client, service)
    near = difflib.get_close_matches(namespace.rstrip("/"), everyone, n=1) or everyone
    hint = f"there is {', '.join(near)}" if near else "no such node is running"
    print(f"{problem}; {hint}", file=sys.stderr)
