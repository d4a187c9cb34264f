"""Private master on which the signal generator courseworks of several packages run in turn."""

import contextlib
import os
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import roslib.message
import rospkg

from pid_control.programs.package_messages import (
    check_legal,
    definitions,
    generate,
    package_name,
)
from pid_control.programs.private_master import PrivateMaster
from pid_control.programs.program_command import workspace_environment
from pid_control.runner.judging_errors import JudgingError
from pid_control.signal_judging.evidence import CourseworkEvidence
from pid_control.signal_runner.coursework import find_coursework, package_folder


class CourseworkRequest(NamedTuple):
    """A coursework to judge, and the options of the judgement.

    :ivar folder: folder of the package
    :ivar words: its launch file, and arguments, if given
    :ivar scenarios: names of the scenarios
    :ivar environment: environment variables of the nodes
    :ivar is_built: whether this is the environment of the package's workspace
    :ivar programs: the only programs to start; empty for all
    :ivar real_time: True for the machine's clock, False for a simulated one
    :ivar time_limit: time limit [s]
    :ivar given: names of channels by node
    """

    folder: str
    words: Sequence[str]
    scenarios: Sequence[str]
    environment: Mapping[str, str]
    is_built: bool = False
    programs: Sequence[str] = ()
    real_time: bool = False
    time_limit: float = 120.0
    given: Mapping[str, str] = {}


def find_request(
    words: Sequence[str], scenarios: Sequence[str], workspace: Optional[str] = None
) -> CourseworkRequest:
    """Return the request to judge a coursework, after a check of the words.

    :param words: package or its folder, and its launch file with arguments, if given
    :param scenarios: names of the scenarios
    :param workspace: the package's workspace if not this one
    :raises CommandError: if package or workspace are not found
    """
    is_built = workspace is not None
    environment = dict(os.environ) if workspace is None else workspace_environment(workspace)
    folder = package_folder(words[0], environment)
    return CourseworkRequest(folder, words[1:], scenarios, environment, is_built)


class CourseworkBench:
    """Private master with a :class:`.SignalBench`; created once per process.

    :ivar notes: notes on the latest coursework
    """

    def __init__(self) -> None:
        self.notes: List[str] = []
        self._count = 0
        self._master = PrivateMaster()
        try:
            # Imported late: rospy reads the master's address when it is imported.
            from pid_control.signal_runner.signal_bench import SignalBench

            self._bench = SignalBench()
        except BaseException:
            self._master.close()
            raise

    def close(self) -> None:
        """End the node and the master."""
        try:
            self._bench.close()
        finally:
            self._master.close()

    def run(self, request: CourseworkRequest) -> Tuple[CourseworkEvidence, str]:
        """Find a coursework, and run its trials.

        :param request: the coursework, and how to judge it
        :returns: evidence of the trials, and why some were not run
        :raises JudgingError: if it cannot be judged
        :raises CommandError: if it is not found
        :raises MessageTypeError: if the package's messages cannot be used
        """
        from pid_control.signal_runner.signal_session import SignalSession

        self.notes = []
        environment = dict(request.environment)
        self._bench.use_classes(self._classes(request, environment))
        coursework = find_coursework(request.folder, request.words, environment, request.programs)
        self.notes += coursework.notes
        session = SignalSession(
            coursework,
            request.scenarios,
            request.real_time,
            request.time_limit,
            request.given,
            self._master,
            self._bench,
        )
        try:
            reason = session.run()
        finally:
            self.notes += session.notes
        if not self._master.is_running():
            raise JudgingError("the judge's own master ended; is this machine out of memory?")
        return session.evidence, reason

    def _classes(
        self, request: CourseworkRequest, environment: Dict[str, str]
    ) -> Mapping[str, Any]:
        """Return the message classes of a package, generated for its nodes too unless built."""
        texts, name = definitions(request.folder), package_name(request.folder)
        if not texts:
            return {}
        check_legal(name)
        self._count += 1
        scratch = os.path.join(self._master.folder, f"messages{self._count}")
        classes = generate(name, texts, scratch)
        if not classes:
            self.notes.append(f"the messages of {name} cannot be generated")
        elif _is_built(request.folder, name, classes):
            return {}
        if not request.is_built:
            path = os.pathsep.join(filter(None, [scratch, environment.get("PYTHONPATH")]))
            environment["PYTHONPATH"] = path
        return classes


def _is_built(folder: str, name: str, classes: Mapping[str, Any]) -> bool:
    """Return True if a package is built in this shell's workspace, with these messages.

    Another package of that name may be built there.
    """
    with contextlib.suppress(rospkg.ResourceNotFound, ImportError, ValueError, AttributeError):
        if os.path.realpath(rospkg.RosPack().get_path(name)) == os.path.realpath(folder):
            found = {msg_type: roslib.message.get_message_class(msg_type) for msg_type in classes}
            return all(found[msg_type]._md5sum == classes[msg_type]._md5sum for msg_type in classes)
    return False
