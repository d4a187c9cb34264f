"""Watcher of the parameter server: detects each change within a second, most within 0.1 s.

The master notifies subscribers of most changes, but not of all: not of a namespace replaced by a
scalar, not after its own restart, and of nothing while three of its subscribers hang. So a
notification only wakes the watcher's thread, one for each process. The thread then reads the
server, and also reads it once a second.
"""

import contextlib
import threading
import time
import traceback
from typing import Any, Collection, Dict, Iterator, List, Optional, Sequence, Set, Tuple

import rospy

from nodekit.master import MasterClient, MasterUnreachable, Reading
from nodekit.parameter_server.watched_key import WatchedKey
from nodekit.parameters.parameter_types import MISSING, is_same
from nodekit.process_context import PROCESS
from nodekit.rospy_internals import parameter_cache, shutdown
from nodekit.rospy_internals.master_registrations import MasterRegistrations
from nodekit.round_robin import RoundRobin
from nodekit.throttle import Throttle

#: Time between two reads without a notification [s].
RECONCILE_S = 1.0
#: Most keys that are read each second without a notification. More keys, as in a process with
#: hundreds of nodes, are read by round robin: reading all would take most of the processor time.
RECONCILE_KEYS = 200
#: A change is complete once two reads this far apart agree [s]: "rosparam
#: load" writes leaf by leaf, much faster than that.
SETTLE_S = 0.02
#: Longest wait until changes settle [s].
SETTLE_LIMIT_S = 0.15
#: Longest wait of :meth:`Watcher.close` for a running callback [s].
CLOSE_LIMIT_S = 1.0
#: Shortest time between two log lines about errors of one key's callback [s].
_LOG_PERIOD_S = 10.0


class Watcher:
    """Watcher of keys of the parameter server, one for the process.

    :param client: client of the master
    :raises MasterUnreachable: if the master does not answer
    """

    def __init__(self, client: MasterClient) -> None:
        self.client = client
        #: All keys, in the order of their opening; replaced and never changed, since several
        #: threads iterate over it.
        self._watched: Dict[WatchedKey, None] = {}
        self._changed = threading.Condition()
        #: Key whose callback is running, and the thread that runs it.
        self._running: Optional[WatchedKey] = None
        self._thread: Optional[threading.Thread] = None
        self._registrations = MasterRegistrations(client)
        self._ahead: Dict[str, Any] = {}
        self._round_robin = RoundRobin(RECONCILE_KEYS)
        self._wake = threading.Event()
        self._reachable = True
        self._ended = False
        self._throttle = Throttle(_LOG_PERIOD_S)
        if not parameter_cache.on_push(self._on_push):
            rospy.logwarn("unsupported rospy version: changes are noticed once a second only")
        self._cache_logging_parameter()
        shutdown.at_end(shutdown.ShutdownPhase.TOOLKIT, self.shut_down)
        threading.Thread(target=self._run, name="parameter_watcher", daemon=True).start()

    def _cache_logging_parameter(self) -> None:
        """Cache the parameter that rospy otherwise reads with each log line.

        rospy would also subscribe to it and never unsubscribe: the master would later send
        updates to another node that has this port by then.
        """
        key = parameter_cache.ROSOUT_PARAMETER
        self._subscribe([key])
        reading = self.client.read([key])
        self._registrations.begin(reading)
        value = reading.values[key]
        parameter_cache.cache(key, value if value is not MISSING else False)

    @contextlib.contextmanager
    def reading_ahead(self, keys: Sequence[str]) -> Iterator[Dict[str, Any]]:
        """Read many keys together, each for one call of :meth:`first_reading` in this context.

        :returns: the raw values by key
        :raises MasterUnreachable: if the master does not answer
        """
        self._ahead = dict(self.client.read(keys).values)
        try:
            yield dict(self._ahead)
        finally:  # later readings must be current
            self._ahead = {}

    def first_reading(self, key: str) -> Any:
        """Return the raw value of a key, read ahead or now.

        :raises MasterUnreachable: if the master does not answer
        """
        return self._ahead.pop(key) if key in self._ahead else self.client.read([key]).values[key]

    def watch(self, watched: Sequence[WatchedKey]) -> None:
        """Watch keys from now on, and pass changes on.

        :raises MasterUnreachable: if the master does not answer; none of them is watched then
        """
        for one in watched:
            one.reset()
        with self._changed:
            self._watched = {**self._watched, **dict.fromkeys(watched)}
        try:
            self._subscribe({one.key for one in watched})
        except MasterUnreachable:
            self.close(*watched)
            raise

    def open(self, watched: Sequence[WatchedKey]) -> None:
        """Watch keys from now on, and pass their values on soon.

        :param watched: keys, watched already or not
        :raises MasterUnreachable: if the master does not answer
        """
        self.watch([one for one in watched if one not in self._watched])
        self.request_report(watched)

    def request_report(self, watched: Sequence[WatchedKey]) -> None:
        """Pass the values of keys on soon, changed or not."""
        for one in watched:
            one.due = True
        self.wake()

    def close(self, *watched: WatchedKey) -> None:
        """Stop watching keys; wait for a running callback, up to 1 s.

        No callback is called after that.
        """
        gone = set(watched)
        with self._changed:
            self._watched = dict.fromkeys(one for one in self._watched if one not in gone)
        if not self._ended:
            self._unsubscribe({one.key for one in gone} - self._keys())
        with self._changed:
            if self._thread is not threading.current_thread():  # which would wait for itself
                self._changed.wait_for(lambda: self._running not in gone, CLOSE_LIMIT_S)

    def wake(self) -> None:
        """Read soon, without waiting for a notification."""
        self._wake.set()

    def shut_down(self) -> None:
        """Stop the thread, and unsubscribe, which rospy itself does not."""
        keys, self._ended = self._keys(), True
        self._unsubscribe(keys)
        self.wake()

    def _keys(self) -> Set[str]:
        """Return the keys to subscribe to."""
        if self._ended:
            return set()
        return {parameter_cache.ROSOUT_PARAMETER, *(one.key for one in self._watched)}

    # Without a lock, which a hung master would hold for long; changes by other threads are
    # corrected afterwards.

    def _subscribe(self, keys: Collection[str]) -> None:
        """Subscribe to keys.

        :raises MasterUnreachable: if the master does not answer
        """
        self.client.subscribe(keys)
        stale = set(keys) - self._keys()
        if stale:
            self._unsubscribe(stale)

    def _unsubscribe(self, keys: Collection[str]) -> None:
        with contextlib.suppress(MasterUnreachable):  # a master that has gone has no subscriptions
            self.client.unsubscribe(keys)
            self.client.subscribe(self._keys().intersection(keys))

    def _on_push(self, key: str, value: Any) -> bool:
        """Store a notification; return whether the key is watched.

        :param key: global name, with or without a trailing slash
        :param value: raw value, an empty dict for a deleted key
        """
        key = key.rstrip("/")
        found = [one for one in self._watched if (key + "/").startswith(one.key + "/")]
        for one in found:
            one.pushed.append((key[len(one.key) + 1 :], MISSING if value == {} else value))
        if found:
            self.wake()
        return bool(found)

    def _run(self) -> None:
        next_read = time.monotonic() + RECONCILE_S
        while not self._ended:
            self._wake.wait(max(0.0, next_read - time.monotonic()))
            self._wake.clear()
            is_due = time.monotonic() >= next_read
            if is_due:
                next_read = time.monotonic() + RECONCILE_S
            turn = self._round_robin.next(list(self._watched)) if is_due else []
            try:
                self._read_and_hand_over(turn)
                if is_due and not self._ended:
                    self._registrations.reclaim_services()
            except MasterUnreachable as error:
                self._log_reachable(False, error)
            except BaseException:  # no error may end this thread
                self._log_defect("the parameters are not followed")
            else:
                self._log_reachable(True)

    def _log_reachable(self, reachable: bool, error: Optional[Exception] = None) -> None:
        if reachable != self._reachable and not self._ended:
            self._reachable = reachable
            if reachable:
                rospy.loginfo("the master answers again")
            else:
                rospy.logwarn("the master does not answer (%s): settings are kept", error)

    def _read_and_hand_over(self, turn: List[WatchedKey]) -> None:
        """Read keys that may have changed; wait until changes settle.

        :param turn: keys to read in any case
        """
        due = [one for one in self._watched if one.is_due]
        watched = list(dict.fromkeys(turn + due))
        read_at, reading = self._read(watched)
        if self._registrations.are_lost:
            watched = list(self._watched)
        elif not self._news(watched, reading):
            return
        limit = read_at + SETTLE_LIMIT_S
        while True:
            time.sleep(SETTLE_S)
            before = reading
            read_at, reading = self._read(watched)
            if is_same(reading.values, before.values) or read_at > limit:
                break
        if self._registrations.are_lost and not self._ended:
            self._register_again()
        self._hand_over(self._news(watched, reading), reading, read_at)

    def _read(self, watched: List[WatchedKey]) -> Tuple[float, Reading]:
        read_at = time.monotonic()
        reading = self.client.read([one.key for one in watched])
        self._registrations.detect_loss(reading)
        return read_at, reading

    def _register_again(self) -> None:
        """Restore all registrations and subscriptions on the master."""
        self._registrations.reregister()
        self._subscribe(self._keys())
        for one in self._watched:
            one.forgotten = True
        self._registrations.log_reregistered()

    def _hand_over(self, watched: List[WatchedKey], reading: Reading, read_at: float) -> None:
        """Pass values on; an error of one callback does not stop the others."""
        unreachable: Optional[MasterUnreachable] = None
        for one in watched:
            with self._changed:
                if one not in self._watched:
                    continue
                self._running, self._thread = one, threading.current_thread()
            try:
                if not one.hand_over(reading.values[one.key], read_at):
                    self.wake()
            except MasterUnreachable as error:
                unreachable = error
            except BaseException:  # also SystemExit: the thread serves all keys
                self._log_defect(f"{one.key} is not followed")
            finally:
                with self._changed:
                    self._running = self._thread = None
                    self._changed.notify_all()
        if unreachable is not None:
            raise unreachable

    def _news(self, watched: List[WatchedKey], reading: Reading) -> List[WatchedKey]:
        """Return the keys whose values have to be passed on."""
        found: List[WatchedKey] = []
        for one in watched:
            try:
                if one.is_news(reading.values[one.key]):
                    found.append(one)
            except BaseException:
                self._log_defect(f"{one.key} is not followed")
        return found

    def _log_defect(self, what: str) -> None:
        if self._throttle.is_due(what):
            rospy.logerr("%s:\n%s", what, traceback.format_exc())


def get_watcher() -> Watcher:
    """Return this process's watcher, created at the first call.

    :returns: the watcher; requires an initialised node
    :raises MasterUnreachable: if the master does not answer
    """

    def create() -> Watcher:
        return Watcher(MasterClient(rospy.get_name(), rospy.get_node_uri()))

    return PROCESS.get(Watcher, create)
