"""Notice every change on the parameter server within a second, most within 0.1 s.

The master notifies subscribers of most changes, but not of all: not of a
namespace replaced by a scalar, not after its own restart, and of nothing at all
while three of its subscribers hang. So a notification only rings a bell. One
thread for each process then reads the truth, and reads it once a second anyway.
"""

import threading
import time
from typing import Any, Deque, Dict, List, NamedTuple, Optional, Tuple
from collections import deque

import rosgraph
import rospy

from basic_comms import rospy_internals
from basic_comms.parameter_server import MISSING, UNREACHABLE, ParameterServer, Reading

#: Time between two reads where no notification arrives, s.
RECONCILE_S = 1.0
#: A change counts as complete once two reads this far apart agree, s: "rosparam
#: load" writes leaf by leaf, in far less than that from one leaf to the next.
SETTLE_S = 0.02
#: Longest wait for changes to come to rest, s.
SETTLE_LIMIT_S = 0.15
#: Notifications kept until the next read; older ones no longer matter.
_MAX_PUSHES = 1000


class Observation(NamedTuple):
    """What the watcher saw of one key.

    :param value: raw value on the server, MISSING where nothing is set
    :param pushed: notified (key, raw value) since the last observation, oldest
        first; a deleted key comes as MISSING
    :param forgotten: the master was restarted and lost what it held
    :param read_at: start of the read, s on the monotonic clock
    """

    value: Any
    pushed: List[Tuple[str, Any]]
    forgotten: bool
    read_at: float


class Watch:
    """Somebody who follows one key of the parameter server; a base class.

    :param key: global name of a parameter or a namespace
    """

    def __init__(self, key: str) -> None:
        self.key = key

    def observe(self, seen: Observation) -> bool:
        """Take note of a change. Called from the watcher's thread.

        :param seen: the change
        :returns: False to be called again after the next read
        :raises UNREACHABLE: if the master does not answer; called again later
        """
        raise NotImplementedError


class ParameterWatcher:
    """Follows keys of the parameter server for everybody in this process.

    :param server: the parameter server to follow
    """

    def __init__(self, server: ParameterServer) -> None:
        self.server = server
        self._watches: List[Watch] = []
        self._seen: Dict[Watch, Any] = {}
        self._pushes: Deque[Tuple[str, Any]] = deque(maxlen=_MAX_PUSHES)
        self._bell = threading.Event()
        self._closed = False
        self._master_pid: Optional[int] = None
        self._forgotten = False
        self._reachable = True
        rospy_internals.on_parameter_push(self._on_push)
        rospy.on_shutdown(self.close)
        threading.Thread(target=self._run, name="parameter_watcher", daemon=True).start()

    def add(self, watch: Watch) -> None:
        """Follow a key from now on; the first observation comes at once.

        :param watch: who follows it; its key must be subscribed already
        """
        self._watches = self._watches + [watch]
        self.ring()

    def ring(self) -> None:
        """Read soon, without waiting for a notification."""
        self._bell.set()

    def close(self) -> None:
        """End the thread and take the subscriptions back.

        rospy leaves them with the master, which then calls a port that some
        other node may have got meanwhile.
        """
        self._closed = True
        try:
            self.server.unsubscribe([watch.key for watch in self._watches])
        except UNREACHABLE:
            pass  # a master that is gone has no subscriptions either

    def _on_push(self, key: str, value: Any) -> bool:
        """Note a notification; tell whether the key is one of ours."""
        key = key.rstrip("/")
        ours = any((key + "/").startswith(watch.key + "/") for watch in self._watches)
        if ours:
            self._pushes.append((key, MISSING if value == {} else value))
            self._bell.set()
        return ours

    def _run(self) -> None:
        while not self._closed:
            self._bell.wait(RECONCILE_S)
            self._bell.clear()
            if self._closed:
                continue
            try:
                self._look()
            except UNREACHABLE as error:
                self._note_reachable(False, error)
            else:
                self._note_reachable(True)

    def _note_reachable(self, reachable: bool, error: Optional[Exception] = None) -> None:
        if reachable != self._reachable and not self._closed:
            self._reachable = reachable
            if reachable:
                rospy.loginfo("the master answers again")
            else:
                rospy.logwarn("the master does not answer (%s): settings stay as they are", error)

    def _look(self) -> None:
        """Read once; where something changed, wait until it rests and pass it on."""
        read_at, reading = self._read()
        if not self._pushes and not self._forgotten and self._unchanged(reading):
            return
        limit = read_at + SETTLE_LIMIT_S
        while True:
            time.sleep(SETTLE_S)
            before = reading
            read_at, reading = self._read()
            if _same(reading.values, before.values) or read_at > limit:
                break
        if self._forgotten:
            rospy.logwarn("the master was restarted: registering again, settings in force are kept")
            rospy_internals.register_again()
            self.server.subscribe(watch.key for watch in self._watches)
        self._pass_on(reading, read_at)
        self._forgotten = False

    def _read(self) -> Tuple[float, Reading]:
        read_at = time.monotonic()
        reading = self.server.read([watch.key for watch in self._watches])
        if not reading.knows_node or self._master_pid not in (None, reading.master_pid):
            # Stays set until everything is written, also if that fails half way.
            self._forgotten = True
        self._master_pid = reading.master_pid
        return read_at, reading

    def _unchanged(self, reading: Reading) -> bool:
        return all(
            watch in self._seen and _same(self._seen[watch], reading.values[watch.key])
            for watch in self._watches
            if watch.key in reading.values
        )

    def _pass_on(self, reading: Reading, read_at: float) -> None:
        pushes = [self._pushes.popleft() for _ in range(len(self._pushes))]
        for watch in self._watches:
            if watch.key not in reading.values:
                continue  # added since the read; its turn comes with the next one
            value = reading.values[watch.key]
            pushed = [push for push in pushes if (push[0] + "/").startswith(watch.key + "/")]
            changed = watch not in self._seen or not _same(self._seen[watch], value)
            if changed or pushed or self._forgotten:
                self._seen.pop(watch, None)
                if watch.observe(Observation(value, pushed, self._forgotten, read_at)):
                    self._seen[watch] = value


def _same(one: Any, other: Any) -> bool:
    """Compare raw values, with NaN equal to itself."""
    return bool(one == other) or repr(one) == repr(other)


_watcher: Optional[ParameterWatcher] = None
_watcher_lock = threading.Lock()


def get_watcher() -> ParameterWatcher:
    """Return this process's watcher, made at the first call.

    :returns: the watcher; the node must have been initialised
    """
    global _watcher
    with _watcher_lock:
        if _watcher is None:
            _watcher = ParameterWatcher(
                ParameterServer(rosgraph.get_master_uri(), rospy.get_name(), rospy.get_node_uri())
            )
        return _watcher
