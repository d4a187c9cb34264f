"""Types of ROS 1 services, which only their servers know."""

import itertools
import threading
from typing import Dict, Optional, Sequence, Set

from nodekit import CallError, MasterUnreachable, RoundRobin, probe_service
from nodekit.master import MasterClient

#: Longest wait for a server [s], and most servers that are asked at once.
_TIMEOUT_S, _MOST = 2.0, 8
#: Most servers that are asked again in a poll: the master lists all of those that were killed.
_AGAIN = 2
#: Most servers in a poll whose addresses are compared with those of before.
_LOOKUPS = 20


class ServiceTypes:
    """Asks the servers, each in a thread of its own, so that one that hangs delays no other.

    :param client: asks the master
    """

    def __init__(self, client: MasterClient) -> None:
        self._client, self._turns = client, RoundRobin(_LOOKUPS)
        self._lock = threading.Lock()
        self._asked: Set[str] = set()
        self._found: Dict[str, str] = {}
        #: Where each was before it was asked: who is elsewhere now may be of another type.
        self._places: Dict[str, str] = {}
        #: Whose servers have not answered, in the order in which they were asked.
        self._silent: Dict[str, None] = {}
        self._again: Set[str] = set()

    def of(self, name: str) -> Optional[str]:
        """Return the type of a service, None where it is not known yet: then it is asked for."""
        with self._lock:
            if name in self._found:
                return self._found[name]
            if name in self._asked or len(self._asked) >= _MOST:
                return None
            if name in self._silent and name not in self._again:
                return None
            self._asked.add(name)
            self._again.discard(name)
        threading.Thread(target=self._ask, args=(name,), daemon=True).start()
        return None

    def begin_poll(self, there: Set[str]) -> None:
        """Forget all services but these, and choose who is asked again.

        :raises MasterUnreachable: if the master does not answer
        """
        with self._lock:
            self._found = {name: kind for name, kind in self._found.items() if name in there}
            self._places = {name: self._places[name] for name in self._found}
            self._silent = {name: None for name in self._silent if name in there}
            self._again = set(itertools.islice(self._silent, _AGAIN))
            turn = self._turns.next(sorted(self._found))
        places = self._look_up(turn)
        with self._lock:
            for name in turn:
                if places[name] != self._places[name]:
                    del self._found[name]

    def _look_up(self, names: Sequence[str]) -> Dict[str, str]:
        """Ask the master where servers are."""
        answers = self._client.request([("lookupService", name) for name in names])
        return {name: str(uri) for name, (_, _, uri) in zip(names, answers)}

    def _ask(self, name: str) -> None:
        said, places = {}, {}
        try:
            places = self._look_up([name])
            said = probe_service(name, _TIMEOUT_S)
        except (CallError, MasterUnreachable):
            pass  # it is asked again when its turn comes
        finally:
            with self._lock:
                self._asked.discard(name)
                self._silent.pop(name, None)
                if "type" in said:
                    self._found[name] = said["type"]
                    self._places.update(places)
                else:
                    self._silent[name] = None
