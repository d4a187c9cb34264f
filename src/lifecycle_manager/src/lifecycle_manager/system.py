# Pure: knows no ROS.
"""Known states of the managed nodes, and the requests to them.

It is told what happens, and the time: that of any clock that never goes back, s.
"""

import math
from typing import List, Optional, Sequence, Tuple

from lifecycle_manager.commands import validated
from lifecycle_manager.node_state import GET_STATE, RESULTS, NodeState, state_text
from lifecycle_manager.plan import DOWN, Level, next_instruction

#: Time between two queries of a node that is in a transition or does not answer, s.
QUERY_EVERY_S = 0.2
#: Longest time that a new manager waits for the states of all nodes, s.
FIRST_QUERY_S = 2.0
#: Time between two checks from which on it was the manager itself that had stopped, s.
PAUSE_S = 0.3


class System:
    """The nodes in their order, and how far up they are to be.

    :param names: of the nodes, in order
    :param autostart: whether they are brought up without a command
    :param now: the time

    :ivar goal: how far up they are to be; None until their states are known
    :ivar problem: why they are not at the goal; empty where they are, or will be
    """

    def __init__(self, names: Sequence[str], autostart: bool, now: float) -> None:
        self.members = [NodeState(name, now) for name in names]
        self.goal: Optional[Level] = None
        self.problem = ""
        self._autostart = autostart
        self._told_at = self._checked_at = now

    # What happens.

    def command(self, number: int, now: float) -> None:
        """Take a command.

        :param number: of the command
        :raises ValueError: if there is no such command, or it is not allowed now
        """
        self.goal = validated(number, self._meant()).goal
        self.problem = ""
        self._told_at = now
        for member in self.members:
            member.is_stuck = False

    def record_heartbeat(self, member: NodeState, now: float) -> None:
        """Record a heartbeat; query the state of a node that had none before."""
        member.heard_at = now
        if not member.is_heard:
            member.is_heard = True
            member.query_at = now

    def record_state(self, member: NodeState, state: int, now: float) -> None:
        """Record the state that a node publishes; query it where it is news, as it may be old."""
        if member.under_way:
            member.told = state  # not to be told again; the answer may be older
        elif member.is_heard and state != member.state:
            member.query_at = now

    def mark_lost(self, member: NodeState, why: str, now: float) -> None:
        """Record that a node has gone.

        :param why: how that was noticed
        """
        member.is_heard = False
        member.query_at = math.inf
        member.under_way, member.told = "", 0
        member.enter(0, now)
        if self._meant() > Level.UNCONFIGURED:
            self.problem = f"{member.name} is lost: {why}"

    def record_answer(self, member: NodeState, state: int, why: str, now: float) -> None:
        """Record the result of a request to a node.

        :param state: number of its state, 0 where it has not answered
        :param why: what went wrong, as far as that is known
        """
        label, member.under_way = member.under_way, ""
        told, member.told = member.told, 0
        member.enter(state, now)
        if member.is_moving or not state:
            member.query_at = now + QUERY_EVERY_S
        elif told not in (0, state):
            member.query_at = now
        # One that has shut down meanwhile is lost rather than to blame: it may come back.
        if member.level > Level.GONE and state != RESULTS.get(label, state):
            result = why or f"it is {state_text(state)}; its log says why"
            self._fail(f"{member.name}: {label} failed: {result}")
            member.is_stuck = label in DOWN.values()
        if self.is_reached and self._meant() > Level.UNCONFIGURED:
            self.problem = ""

    def check_timeouts(self, heartbeat_timeout: float, respawn_window: float, now: float) -> None:
        """Record what has not happened in time; to be called regularly.

        :param heartbeat_timeout: longest time between two heartbeats, s
        :param respawn_window: longest time until a node that is not there has to be back, s
        """
        pause, self._checked_at = now - self._checked_at, now
        for member in self.members:
            if pause > PAUSE_S:  # no heartbeat could be received meanwhile
                member.heard_at = min(now, member.heard_at + pause)
            if member.is_heard and now - member.heard_at > heartbeat_timeout:
                self.mark_lost(member, f"no heartbeat for {heartbeat_timeout:g} s", now)
        if self.goal is None:
            if all(member.rests for member in self.members) or now - self._told_at > FIRST_QUERY_S:
                self._adopt_found_state(now)
        elif self.goal > Level.UNCONFIGURED:
            for member in self.members:
                if member.is_overdue(self._told_at, respawn_window, now):
                    where = (
                        f"has been {state_text(member.state)} for longer than {respawn_window:g} s"
                    )
                    self._fail(f"{member.name} {where}: all others stay down until commanded")

    # What follows from it.

    def ask_next(self, now: float) -> Optional[NodeState]:
        """Return the next node to send a request to, which is then under way; None for none."""
        members = list(enumerate(self.members))
        for _, member in members:
            if not member.under_way and member.query_at <= now:
                member.under_way = GET_STATE
                member.query_at = math.inf
                return member
        busy = {place: each.under_way or GET_STATE for place, each in members if each.is_busy}
        stuck = [place for place, each in members if each.is_stuck]
        if self.goal is None:
            return None
        instruction = next_instruction(self.goal, self.levels, busy, stuck)
        if instruction is None:
            return None
        member = self.members[instruction.place]
        member.under_way = instruction.label
        return member

    def settle(self) -> Optional[Tuple[bool, str]]:
        """Return the result of a command, None while it goes on; to be called after all requests.

        :returns: whether all nodes are where they are to be, and a sentence
        """
        goal = self.goal
        if goal is None or any(member.under_way for member in self.members):
            return None
        if goal > Level.UNCONFIGURED and not all(member.rests for member in self.members):
            return None
        is_good = self.is_reached and not self.problem
        summary = self.summary
        if goal is Level.GONE:  # nodes that are started from now on are new ones
            self.goal = Level.UNCONFIGURED
        return is_good, summary

    @property
    def levels(self) -> List[Level]:
        """Levels of the nodes, in order."""
        return [member.level for member in self.members]

    @property
    def is_reached(self) -> bool:
        """Whether all nodes are where they are to be."""
        return not self._others()

    @property
    def is_active(self) -> bool:
        """Whether all nodes are active, and are to be."""
        return self.goal is Level.ACTIVE and self.is_reached

    @property
    def summary(self) -> str:
        """Status of the nodes in words."""
        if self.problem:
            return self.problem
        if self.is_reached:
            return f"all are {state_text(self.goal or 4)}"
        return ", ".join(f"{each.name} is {state_text(each.state)}" for each in self._others())

    def _others(self) -> List[NodeState]:
        """Return the nodes that are not where they are to be."""
        return [each for each in self.members if each.is_moving or each.level != self.goal]

    def _meant(self) -> Level:
        """Return how far up the nodes are to be, or where they have been found."""
        return self.goal if self.goal is not None else max(Level.UNCONFIGURED, min(self.levels))

    def _adopt_found_state(self, now: float) -> None:
        """Take the states that were found for the goal; with autostart, go up from unconfigured."""
        self.goal, self._told_at = self._meant(), now
        if self._autostart and self.goal is Level.UNCONFIGURED:
            self.goal = Level.ACTIVE

    def _fail(self, problem: str) -> None:
        """Bring all nodes down, and keep them there until the next command."""
        self.goal = min(self._meant(), Level.UNCONFIGURED)
        self.problem = problem
