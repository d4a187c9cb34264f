"""Who follows which key of the parameter server, and what they have not been told of yet."""

import contextlib
import threading
from typing import (
    Any,
    Callable,
    Collection,
    Dict,
    List,
    NamedTuple,
    Optional,
    Sequence,
    Set,
    Tuple,
)

import rospy

from nodekit.master import MasterClient, MasterUnreachable
from nodekit.parameters.kinds import MISSING
from nodekit.parameters.reconciler import Seen
from nodekit.rospy_internals.parameters import ROSOUT_PARAMETER

#: Longest wait of :meth:`Followers.remove` for what is under way, s.
REMOVE_LIMIT_S = 1.0


class Follower(NamedTuple):
    """Somebody who follows one key.

    :param key: global name of a parameter or a namespace
    :param is_news: tells whether a raw value is another one than expected
    :param take: takes note of what was seen, in the thread of the watcher; returns False
        to be called again after the next read, as if this call had not been; raises
        MasterUnreachable to be called again later
    """

    key: str
    is_news: Callable[[Any], bool]
    take: Callable[[Seen], bool]


class Entry:
    """What is known of one follower."""

    def __init__(self, follower: Follower) -> None:
        self.follower = follower
        self.key = follower.key
        #: Notifications that it has not taken yet, oldest first.
        self.pushed: List[Tuple[str, Any]] = []
        #: Whether it still has to be told that the master was restarted.
        self.forgotten = False
        #: Whether it is to be told whatever is read.
        self.due = False

    @property
    def is_due(self) -> bool:
        """Whether there is a reason to read the key."""
        return self.due or self.forgotten or bool(self.pushed)

    def is_news(self, raw: Any) -> bool:
        """Tell whether the follower is to be told of a raw value that was read."""
        return self.is_due or self.follower.is_news(raw)

    def tell(self, raw: Any, read_at: float) -> bool:
        """Tell the follower; return whether it is done with that.

        :param raw: value of the key, MISSING where nothing is set
        :param read_at: start of the read, s on the monotonic clock
        """
        pushed, is_done = list(self.pushed), False
        self.due = False  # before: who asks meanwhile is to be told once more
        try:
            is_done = self.follower.take(Seen(raw, pushed, self.forgotten, read_at))
        finally:  # also where this raises
            self.due = self.due or not is_done
        if is_done:
            self.forgotten = False
            del self.pushed[: len(pushed)]
        return is_done


class Followers:
    """All followers in this process, and what the master notifies of for them.

    :param client: asks the master

    :ivar entries: of all followers; replaced and never changed, since several threads
        walk through it
    """

    def __init__(self, client: MasterClient) -> None:
        self._client = client
        self.entries: Dict[Follower, Entry] = {}
        self.ended = False
        self._changed = threading.Condition()
        self._told: Optional[Entry] = None
        self._teller: Optional[threading.Thread] = None

    def keys(self) -> Set[str]:
        """Return what the master is to notify of."""
        if self.ended:
            return set()
        return {ROSOUT_PARAMETER, *(follower.key for follower in self.entries)}

    def add(self, followers: Sequence[Follower]) -> None:
        """Keep the notifications for some more.

        :raises MasterUnreachable: if the master does not answer; nobody is added then
        """
        added = {follower: Entry(follower) for follower in followers}
        with self._changed:
            self.entries = {**self.entries, **added}
        try:
            self.subscribe({follower.key for follower in followers})
        except MasterUnreachable:
            self.remove(followers)
            raise

    def remove(self, followers: Sequence[Follower]) -> None:
        """Forget some; one that is being told is waited for, up to 1 s.

        Afterwards none of them is told any more.
        """
        gone = set(followers)
        with self._changed:
            self.entries = {one: entry for one, entry in self.entries.items() if one not in gone}
        if not self.ended:
            self._unsubscribe({follower.key for follower in gone} - self.keys())
        with self._changed:
            if self._teller is not threading.current_thread():  # or it would wait for itself
                self._changed.wait_for(
                    lambda: self._told is None or self._told.follower not in gone, REMOVE_LIMIT_S
                )

    def end(self) -> None:
        """Take all subscriptions back, which rospy itself does not."""
        keys, self.ended = self.keys(), True
        self._unsubscribe(keys)

    # Without a lock, which a hung master would keep for long: what has changed meanwhile, in
    # another thread, is put right afterwards.

    def subscribe(self, keys: Collection[str]) -> None:
        """Have the master notify of keys.

        :raises MasterUnreachable: if the master does not answer
        """
        self._client.subscribe(keys)
        stale = set(keys) - self.keys()
        if stale:
            self._unsubscribe(stale)

    def _unsubscribe(self, keys: Collection[str]) -> None:
        with contextlib.suppress(MasterUnreachable):  # one that is gone has no subscriptions
            self._client.unsubscribe(keys)
            self._client.subscribe(self.keys().intersection(keys))

    def note(self, key: str, value: Any) -> bool:
        """Note a notification; tell whether anybody follows the key.

        :param key: global name, with or without a slash at its end
        :param value: its raw value, an empty dict where it was deleted
        """
        key = key.rstrip("/")
        entries = self.entries.values()
        found = [entry for entry in entries if (key + "/").startswith(entry.key + "/")]
        for entry in found:
            name = key[len(entry.key) + 1 :]
            entry.pushed.append((name, MISSING if value == {} else value))
        return bool(found)

    def tell(self, entry: Entry, raw: Any, read_at: float) -> bool:
        """Tell a follower, unless it has been removed; as :meth:`Entry.tell`."""
        with self._changed:
            if self.entries.get(entry.follower) is not entry:
                return True
            self._told, self._teller = entry, threading.current_thread()
        try:
            return entry.tell(raw, read_at)
        finally:
            with self._changed:
                self._told = self._teller = None
                self._changed.notify_all()


def call_listener(listener: Callable[[], object], key: str) -> None:
    """Call a function of somebody else's, whose defects must keep nobody else from being told.

    :param listener: the function
    :param key: what it listens to
    """
    try:
        listener()
    except (Exception, SystemExit):
        rospy.logerr("%s: a listener failed", key, exc_info=True)
