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
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple

import rospy

from nodekit.master import MasterClient, MasterUnreachable, Reading, Turns
from nodekit.parameter_server.followers import Entry, Follower, Followers
from nodekit.parameter_server.registrations import Registrations
from nodekit.parameters.kinds import MISSING, is_same
from nodekit.rospy_internals import parameters, shutdown

#: Time between two reads where no notification arrives, s.
RECONCILE_S = 1.0
#: Most keys that are read each second without a notification. Where there are
#: more, as in a process that hosts hundreds of nodes, they take turns: reading
#: them all would cost more than all else that the process does.
RECONCILE_KEYS = 200
#: A change counts as complete once two reads this far apart agree, s: "rosparam
#: load" writes leaf by leaf, in far less than that from one leaf to the next.
SETTLE_S = 0.02
#: Longest wait for changes to come to rest, s.
SETTLE_LIMIT_S = 0.15
#: A defect of a follower is logged at most this often, s.
_LOG_PERIOD_S = 10.0


class Watcher:
    """Follows keys of the parameter server for everybody in this process.

    :param client: asks the master
    :raises MasterUnreachable: if the master does not answer
    """

    def __init__(self, client: MasterClient) -> None:
        self.client = client
        self._followers = Followers(client)
        self._registrations = Registrations(client)
        self._ahead: Dict[str, Any] = {}
        self._turns = Turns(RECONCILE_KEYS)
        self._bell = threading.Event()
        self._reachable = True
        self._logged: Dict[str, float] = {}
        if not parameters.on_push(self._on_push):
            rospy.logwarn("this rospy is not known: changes are noticed once a second only")
        self._take_over_logging()
        shutdown.at_end(shutdown.Ending.TOOLKIT, self.shut_down)
        threading.Thread(target=self._run, name="parameter_watcher", daemon=True).start()

    def _take_over_logging(self) -> None:
        """Spare the master a question for each line of the log, and rospy a subscription.

        One left behind is no trifle: the master would shut down whoever has this port by then.
        """
        key = parameters.ROSOUT_PARAMETER
        self._followers.subscribe([key])
        reading = self.client.read([key])
        self._registrations.begin(reading)
        value = reading.values[key]
        parameters.cache(key, value if value is not MISSING else False)

    @contextlib.contextmanager
    def reading_ahead(self, keys: Sequence[str]) -> Iterator[Dict[str, Any]]:
        """Read many keys together, for one call of :meth:`first_reading` each, within this.

        :returns: the raw values by key
        :raises MasterUnreachable: if the master does not answer
        """
        self._ahead = dict(self.client.read(keys).values)
        try:
            yield dict(self._ahead)
        finally:  # what is read later is to be as it is then
            self._ahead = {}

    def first_reading(self, key: str) -> Any:
        """Return the raw value of a key: as read ahead, or else as it is now.

        :raises MasterUnreachable: if the master does not answer
        """
        return self._ahead.pop(key) if key in self._ahead else self.client.read([key]).values[key]

    def subscribe(self, followers: Sequence[Follower]) -> None:
        """Follow keys from now on; the followers are told when something is news to them.

        :raises MasterUnreachable: if the master does not answer; nobody is followed then
        """
        self._followers.add(followers)

    def open(self, followers: Sequence[Follower]) -> None:
        """Follow keys from now on, and tell each follower soon what there is.

        :param followers: subscribed already or not
        :raises MasterUnreachable: if the master does not answer
        """
        self.subscribe([one for one in followers if one not in self._followers.entries])
        self.tell(followers)

    def tell(self, followers: Sequence[Follower]) -> None:
        """Tell each follower soon what there is, whether it is news or not."""
        for entry in map(self._followers.entries.get, followers):
            if entry is not None:
                entry.due = True
        self.ring()

    def close(self, *followers: Follower) -> None:
        """Follow keys no longer, and wait up to 1 s for a follower that is being told."""
        self._followers.remove(followers)

    def ring(self) -> None:
        """Read soon, without waiting for a notification."""
        self._bell.set()

    def shut_down(self) -> None:
        """End the thread and take the subscriptions back, which rospy itself does not."""
        self._followers.end()
        self.ring()

    def _on_push(self, key: str, value: Any) -> bool:
        """Note a notification; tell whether anybody follows the key."""
        is_followed = self._followers.note(key, value)
        if is_followed:
            self.ring()
        return is_followed

    def _run(self) -> None:
        next_turn = time.monotonic() + RECONCILE_S
        while not self._followers.ended:
            self._bell.wait(max(0.0, next_turn - time.monotonic()))
            self._bell.clear()
            is_due = time.monotonic() >= next_turn
            if is_due:
                next_turn = time.monotonic() + RECONCILE_S
            turn = self._turns.next(list(self._followers.entries.values())) if is_due else []
            try:
                self._look(turn)
                if is_due and not self._followers.ended:
                    self._registrations.look_after_services()
            except MasterUnreachable as error:
                self._note_reachable(False, error)
            except BaseException:  # no defect may end this thread
                self._log_defect("the parameters are not followed")
            else:
                self._note_reachable(True)

    def _note_reachable(self, reachable: bool, error: Optional[Exception] = None) -> None:
        if reachable != self._reachable and not self._followers.ended:
            self._reachable = reachable
            if reachable:
                rospy.loginfo("the master answers again")
            else:
                rospy.logwarn("the master does not answer (%s): settings stay as they are", error)

    def _look(self, turn: List[Entry]) -> None:
        """Read what may have changed; where something has, wait until it rests.

        :param turn: whose keys are read in any case
        """
        due = [entry for entry in self._followers.entries.values() if entry.is_due]
        entries = list(dict.fromkeys(turn + due))
        read_at, reading = self._read(entries)
        if self._registrations.are_lost:
            entries = list(self._followers.entries.values())
        elif not self._news(entries, reading):
            return
        limit = read_at + SETTLE_LIMIT_S
        while True:
            time.sleep(SETTLE_S)
            before = reading
            read_at, reading = self._read(entries)
            if is_same(reading.values, before.values) or read_at > limit:
                break
        if self._registrations.are_lost and not self._followers.ended:
            self._begin_anew()
        self._pass_on(self._news(entries, reading), reading, read_at)

    def _read(self, entries: List[Entry]) -> Tuple[float, Reading]:
        read_at = time.monotonic()
        reading = self.client.read([entry.key for entry in entries])
        self._registrations.note(reading)
        return read_at, reading

    def _begin_anew(self) -> None:
        """Tell a master all that it has to know and does not any more."""
        self._registrations.renew()
        self._followers.subscribe(self._followers.keys())
        for entry in self._followers.entries.values():
            entry.forgotten = True
        self._registrations.renewed()

    def _pass_on(self, entries: List[Entry], reading: Reading, read_at: float) -> None:
        """Tell each follower; one that fails keeps no other from being told."""
        unreachable: Optional[MasterUnreachable] = None
        for entry in entries:
            try:
                if not self._followers.tell(entry, reading.values[entry.key], read_at):
                    self.ring()
            except MasterUnreachable as error:
                unreachable = error
            except BaseException:  # also what ends a thread: this one is everybody's
                self._log_defect(f"{entry.key} is not followed")
        if unreachable is not None:
            raise unreachable

    def _news(self, entries: List[Entry], reading: Reading) -> List[Entry]:
        """Return who is to be told of what was read."""
        found: List[Entry] = []
        for entry in entries:
            try:
                if entry.is_news(reading.values[entry.key]):
                    found.append(entry)
            except BaseException:
                self._log_defect(f"{entry.key} is not followed")
        return found

    def _log_defect(self, what: str) -> None:
        now = time.monotonic()
        if now - self._logged.get(what, -_LOG_PERIOD_S) >= _LOG_PERIOD_S:
            self._logged[what] = now
            rospy.logerr("%s:\n%s", what, traceback.format_exc())


_watcher: Optional[Watcher] = None
_watcher_lock = threading.Lock()


def get_watcher() -> Watcher:
    """Return this process's watcher, made at the first call.

    :returns: the watcher; the node must have been initialised
    :raises MasterUnreachable: if the master does not answer
    """
    global _watcher
    with _watcher_lock:
        if _watcher is None:
            _watcher = Watcher(MasterClient(rospy.get_name(), rospy.get_node_uri()))
        return _watcher
