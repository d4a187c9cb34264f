"""Types of ROS 1 services, requested from their servers."""

import itertools
import threading
from typing import Dict, Optional, Sequence, Set, Tuple

from nodekit import CallError, MasterUnreachable, RoundRobin, probe_service
from nodekit.master import MasterClient

#: Timeout of a server [s], and most servers queried at a time.
_TIMEOUT_S, _MOST = 2.0, 8
#: Most servers queried again per poll: the master lists all killed servers.
_AGAIN = 2
#: A server counts as unreachable after this many queries: the first one may be too early.
_TRIES = 2
#: Most servers per poll whose addresses are compared with the previous ones.
_LOOKUPS = 20


class ServiceTypes:
    """Types of services; each server is queried in its own thread, so that none delays the others.

    :param client: client of the master
    """

    def __init__(self, client: MasterClient) -> None:
        self._client, self._round_robin = client, RoundRobin(_LOOKUPS)
        self._lock = threading.Lock()
        self._asked: Set[str] = set()
        self._found: Dict[str, str] = {}
        #: Address of each server before the query: at a new address, the type may differ.
        self._places: Dict[str, str] = {}
        #: Services without an answer, in the order of the queries: their number, and the reason.
        self._silent: Dict[str, Tuple[int, str]] = {}
        #: Services that were requested since the last poll; and of those, which to query again.
        self._requested: Set[str] = set()
        self._again: Set[str] = set()

    def of(self, name: str) -> Optional[str]:
        """Return the type of a service; None if it is not known yet, which starts a query."""
        with self._lock:
            if name in self._found:
                return self._found[name]
            self._requested.add(name)
            if name in self._asked or len(self._asked) >= _MOST:
                return None
            if name in self._silent and name not in self._again:
                return None
            self._asked.add(name)
            self._again.discard(name)
        threading.Thread(target=self._ask, args=(name,), daemon=True).start()
        return None

    def begin_poll(self, there: Set[str]) -> None:
        """Drop all other services, and choose those to query again.

        :raises MasterUnreachable: if the master does not answer
        """
        with self._lock:
            self._found = {name: kind for name, kind in self._found.items() if name in there}
            self._places = {name: self._places[name] for name in self._found}
            self._silent = {name: told for name, told in self._silent.items() if name in there}
            again = (name for name in self._silent if name in self._requested)
            self._again, self._requested = set(itertools.islice(again, _AGAIN)), set()
            turn = self._round_robin.next(sorted(self._found))
        places = self._look_up(turn)
        with self._lock:
            for name in turn:
                if places[name] != self._places[name]:
                    del self._found[name]

    def unanswered(self) -> Dict[str, str]:
        """Return the reason for each service whose server has not answered repeatedly."""
        with self._lock:
            return {name: why for name, (tries, why) in self._silent.items() if tries >= _TRIES}

    def _look_up(self, names: Sequence[str]) -> Dict[str, str]:
        """Request the addresses of servers from the master."""
        answers = self._client.request([("lookupService", name) for name in names])
        return {name: str(uri) for name, (_, _, uri) in zip(names, answers)}

    def _ask(self, name: str) -> None:
        header, places, why = {}, {}, ""
        try:
            places = self._look_up([name])
            header = probe_service(name, _TIMEOUT_S)
            why = "its header has no type"
        except CallError as error:  # a later poll queries it again
            why = str(error)
        except MasterUnreachable:
            pass  # the server may still answer
        finally:
            with self._lock:
                self._asked.discard(name)
                tries, before = self._silent.pop(name, (0, ""))
                if "type" in header:
                    self._found[name] = header["type"]
                    self._places.update(places)
                else:
                    self._silent[name] = tries + bool(why), why or before
