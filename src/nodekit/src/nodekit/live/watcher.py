"""Notice every change on the parameter server within a second, most within 0.1 s.

The master notifies subscribers of most changes, but not of all: not of a
namespace replaced by a scalar, not after its own restart, and of nothing at all
while three of its subscribers hang. So a notification only rings a bell. One
thread for each process then reads the truth, and reads it once a second anyway.
"""

import contextlib
import threading
import time
import traceback
from collections import deque
from typing import Any, Deque, Iterator, List, NamedTuple, Optional, Sequence, Set, Tuple

import rosgraph
import rospy

from nodekit.live.parameter_server import UNREACHABLE, ParameterServer, Reading, parts
from nodekit.parameters.kinds import is_same
from nodekit.parameters.no_value import MISSING, NoValue
from nodekit.rospy_internals import parameters, registration, shutdown

#: Time between two reads where no notification arrives, s.
RECONCILE_S = 1.0
#: Most keys that are read each second without a notification. Where there are
#: more, as in a fleet of hundreds of groups, they take turns: reading them all
#: would cost more than all else that the fleet does.
RECONCILE_KEYS = 200
#: A change counts as complete once two reads this far apart agree, s: "rosparam
#: load" writes leaf by leaf, in far less than that from one leaf to the next.
SETTLE_S = 0.02
#: Longest wait for changes to come to rest, s.
SETTLE_LIMIT_S = 0.15
#: A defect of a watch is logged at most this often, s.
_LOG_PERIOD_S = 10.0
_UNKNOWN = NoValue("UNKNOWN")


class Observation(NamedTuple):
    """What the watcher saw of one key.

    :param value: raw value on the server, MISSING where nothing is set
    :param pushed: notified (key, raw value) since the last observation that was
        taken note of, oldest first; a deleted key comes as MISSING
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
        #: What the server is to hold by now; another value is news. Whoever
        #: writes to the server keeps this up to date.
        self.known: Any = _UNKNOWN
        #: Notifications that have not been taken note of yet.
        self.pushes: Deque[Tuple[str, Any]] = deque()

    def observe(self, seen: Observation) -> bool:
        """Take note of a change. Called from the watcher's thread.

        :param seen: the change
        :returns: False to be called again after the next read, as if this call
            had not been
        :raises UNREACHABLE: if the master does not answer; called again later
        """
        raise NotImplementedError


class ParameterWatcher:
    """Follows keys of the parameter server for everybody in this process.

    :param server: the parameter server to follow
    """

    def __init__(self, server: ParameterServer) -> None:
        self.server = server
        self._lock = threading.Lock()
        #: Those whose notifications are kept, and of them those who are told. Both
        #: lists are replaced and never changed, since other threads walk through them.
        self._subscribed: List[Watch] = []
        self._watches: List[Watch] = []
        self._turn_from = 0
        self._bell = threading.Event()
        self._closed = False
        self._master_pid: Optional[int] = None
        self._restarted = False
        #: Those who have not been told yet that the master was restarted.
        self._lost: Set[Watch] = set()
        self._reachable = True
        self._looking = threading.Lock()
        self._starting_together = False
        if not parameters.on_push(self._on_push):
            rospy.logwarn("this rospy is not known: changes are noticed once a second only")
        self._take_over_logging()
        shutdown.at_shutdown(self.close)
        threading.Thread(target=self._run, name="parameter_watcher", daemon=True).start()

    def _take_over_logging(self) -> None:
        """Spare the master a question for each line of the log, and rospy a subscription.

        A subscription that is left behind is no trifle: should the node be
        started anew, the master would shut down whoever has its old port by then.
        """
        key = parameters.ROSOUT_PARAMETER
        self._subscribe([key])
        value = self.server.read([key]).values[key]
        parameters.cache(key, value if value is not MISSING else False)

    def subscribe(self, watch: Watch) -> None:
        """Keep the notifications of a key until :meth:`add`.

        A change from now on is not missed, also if the value is replaced
        before it is read.

        :param watch: who will follow the key
        :raises UNREACHABLE: if the master does not answer
        """
        with self._lock:
            if watch not in self._subscribed:
                self._subscribed = self._subscribed + [watch]
        if not self._starting_together:
            self._subscribe([watch.key])

    def add(self, watch: Watch) -> None:
        """Follow a key from now on; the first observation comes at once.

        :param watch: who follows it
        :raises UNREACHABLE: if the master does not answer
        """
        if watch not in self._subscribed:
            self.subscribe(watch)
        with self._lock:
            self._watches = self._watches + [watch]
        self.ring()

    @contextlib.contextmanager
    def starting_together(self, keys: Sequence[str]) -> Iterator[None]:
        """Start many watches with a few requests in place of several for each.

        Nothing is followed meanwhile; what has changed by the end is noticed then.

        :param keys: global names of all that the watches will read
        :raises UNREACHABLE: if the master does not answer
        """
        with self._looking:
            before = len(self._subscribed)
            self._starting_together = True
            try:
                with self.server.in_advance(keys):
                    yield
            finally:
                self._starting_together = False
            for part in parts([watch.key for watch in self._subscribed[before:]]):
                self._subscribe(part)

    def remove(self, watch: Watch) -> None:
        """Follow a key no longer.

        :param watch: who followed it
        """
        with self._lock:
            self._watches = [other for other in self._watches if other is not watch]
            self._subscribed = [other for other in self._subscribed if other is not watch]
        if all(other.key != watch.key for other in self._subscribed):
            self._unsubscribe([watch.key])

    def ring(self) -> None:
        """Read soon, without waiting for a notification."""
        self._bell.set()

    def close(self) -> None:
        """End the thread and take the subscriptions back, which rospy itself does not."""
        self._closed = True
        self._unsubscribe(self._keys())

    def _keys(self) -> List[str]:
        return [parameters.ROSOUT_PARAMETER] + [watch.key for watch in self._subscribed]

    def _subscribe(self, keys: Sequence[str]) -> None:
        self.server.subscribe(keys)
        if self._closed:
            self._unsubscribe(keys)  # close() may have come before it, in another thread

    def _unsubscribe(self, keys: Sequence[str]) -> None:
        try:
            self.server.unsubscribe(keys)
        except UNREACHABLE:
            pass  # a master that is gone has no subscriptions either

    def _on_push(self, key: str, value: Any) -> bool:
        """Note a notification; tell whether the key is one of ours."""
        key = key.rstrip("/")
        followers = [watch for watch in self._subscribed if (key + "/").startswith(watch.key + "/")]
        for watch in followers:
            watch.pushes.append((key, MISSING if value == {} else value))
        if followers:
            self.ring()
        return bool(followers)

    def _run(self) -> None:
        next_turn = time.monotonic() + RECONCILE_S
        while not self._closed:
            self._bell.wait(max(0.0, next_turn - time.monotonic()))
            self._bell.clear()
            if self._closed:
                continue
            turn: List[Watch] = []
            if time.monotonic() >= next_turn:
                next_turn = time.monotonic() + RECONCILE_S
                turn = self._next_turn()
            try:
                with self._looking:
                    self._look(turn)
            except UNREACHABLE as error:
                self._note_reachable(False, error)
            else:
                self._note_reachable(True)

    def _next_turn(self) -> List[Watch]:
        """Return whose keys are read this second, whatever the master notifies."""
        watches = self._watches[self._turn_from :][:RECONCILE_KEYS]
        self._turn_from += RECONCILE_KEYS
        if self._turn_from >= len(self._watches):
            self._turn_from = 0
        return watches

    def _note_reachable(self, reachable: bool, error: Optional[Exception] = None) -> None:
        if reachable != self._reachable and not self._closed:
            self._reachable = reachable
            if reachable:
                rospy.loginfo("the master answers again")
            else:
                rospy.logwarn("the master does not answer (%s): settings stay as they are", error)

    def _look(self, turn: List[Watch]) -> None:
        """Read what may have changed; where something has, wait until it rests.

        :param turn: whose keys are read in any case
        """
        watches = turn + [watch for watch in self._watches if self._is_due(watch)]
        read_at, reading = self._read(watches)
        if self._restarted:
            watches = self._watches
        elif self._unchanged(reading):
            return
        limit = read_at + SETTLE_LIMIT_S
        while True:
            time.sleep(SETTLE_S)
            before = reading
            read_at, reading = self._read(watches)
            if is_same(reading.values, before.values) or read_at > limit:
                break
        if self._restarted and not self._closed:
            rospy.logwarn("the master was restarted: registering again, settings in force are kept")
            registration.register_again()
            self._subscribe(self._keys())
            self._lost = set(self._subscribed)
            self._restarted = False
        self._pass_on(reading, read_at)

    def _read(self, watches: List[Watch]) -> Tuple[float, Reading]:
        read_at = time.monotonic()
        reading = self.server.read([watch.key for watch in watches])
        if not reading.knows_node or self._master_pid not in (None, reading.master_pid):
            self._restarted = True
        self._master_pid = reading.master_pid
        return read_at, reading

    def _is_due(self, watch: Watch) -> bool:
        """Tell whether there is a reason to read a key."""
        return bool(watch.pushes) or watch.known is _UNKNOWN or watch in self._lost

    def _is_news(self, watch: Watch, reading: Reading) -> bool:
        return self._is_due(watch) or not is_same(watch.known, reading.values[watch.key])

    def _unchanged(self, reading: Reading) -> bool:
        # One whose key was not read has its turn with the next read.
        watches = [watch for watch in self._watches if watch.key in reading.values]
        return not any(self._is_news(watch, reading) for watch in watches)

    def _pass_on(self, reading: Reading, read_at: float) -> None:
        unreachable: Optional[Exception] = None
        for watch in self._watches:
            if watch.key in reading.values and self._is_news(watch, reading):
                try:
                    self._tell(watch, reading.values[watch.key], read_at)
                except UNREACHABLE as error:
                    unreachable = error
                except Exception:  # a defect of one watch must not end this thread for all
                    text = "%s is not followed:\n%s" % (watch.key, traceback.format_exc())
                    rospy.logerr_throttle(_LOG_PERIOD_S, text)
        if unreachable is not None:
            raise unreachable

    def _tell(self, watch: Watch, value: Any, read_at: float) -> None:
        pushed = list(watch.pushes)
        watch.known = value
        done = False
        try:
            done = watch.observe(Observation(value, pushed, watch in self._lost, read_at))
        finally:
            if not done:
                watch.known = _UNKNOWN
        if done:
            self._lost.discard(watch)
            for _ in pushed:
                watch.pushes.popleft()


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
