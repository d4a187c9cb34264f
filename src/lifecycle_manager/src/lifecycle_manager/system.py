# Pure: knows no ROS.
"""States of the managed nodes, and the requests to them.

Events and time are arguments; the time is that of any monotonic clock [s].
"""

import math
from typing import List, Optional, Sequence, Tuple

from lifecycle_manager.commands import validated
from lifecycle_manager.node_state import GET_STATE, RESULTS, NodeState, state_text
from lifecycle_manager.plan import DOWN, Level, next_instruction

#: Interval of queries of a node that is in transition or does not answer [s].
QUERY_EVERY_S = 0.2
#: Longest time that a new manager waits for the states of all nodes [s].
FIRST_QUERY_S = 2.0
#: From this interval between two checks on, the manager itself was suspended [s].
PAUSE_S = 0.3


class System:
    """The nodes in order, and their common goal.

    :param names: of the nodes, in order
    :param autostart: whether they are brought up without a command
    :param now: current time

    :ivar goal: level that all should reach; None until their states are known
    :ivar problem: why they cannot reach the goal; empty without a problem
    """

    def __init__(self, names: Sequence[str], autostart: bool, now: float) -> None:
        self.members = [NodeState(name, now) for name in names]
        self.goal: Optional[Level] = None
        self.problem = ""
        self._autostart = autostart
        self._goal_set_at = self._checked_at = now

    # Events.

    def command(self, number: int, now: float) -> None:
        """Execute a command.

        :param number: of the command
        :raises ValueError: if there is no such command, or it is not allowed now
        """
        self.goal = validated(number, self._meant()).goal
        self.problem = ""
        self._goal_set_at = now
        for member in self.members:
            member.is_stuck = False

    def record_heartbeat(self, member: NodeState, now: float) -> None:
        """Record a heartbeat; query the state of a node whose heartbeat is new."""
        member.heard_at = now
        if not member.is_heard:
            member.is_heard = True
            member.query_at = now

    def record_state(self, member: NodeState, state: int, now: float) -> None:
        """Record a published state; query it if it is new, because the message may be old."""
        if member.under_way:
            member.published = state  # not published again; the answer may be older
        elif member.is_heard and state != member.state:
            member.query_at = now

    def mark_lost(self, member: NodeState, why: str, now: float) -> None:
        """Record that a node is lost.

        :param why: how that was detected
        """
        member.is_heard = False
        member.query_at = math.inf
        member.under_way, member.published = "", 0
        member.enter(0, now)
        if self._meant() > Level.UNCONFIGURED:
            self.problem = f"{member.name} is lost: {why}"

    def record_answer(self, member: NodeState, state: int, why: str, now: float) -> None:
        """Record the result of a request to a node.

        :param state: number of its state, 0 without an answer
        :param why: the error, if known
        """
        label, member.under_way = member.under_way, ""
        published, member.published = member.published, 0
        member.enter(state, now)
        if member.is_moving or not state:
            member.query_at = now + QUERY_EVERY_S
        elif published not in (0, state):
            member.query_at = now
        # A node that has shut down meanwhile is lost, not failed: it may come back.
        if member.level > Level.GONE and state != RESULTS.get(label, state):
            result = why or f"it is {state_text(state)}; its log says why"
            self._fail(f"{member.name}: {label} failed: {result}")
            member.is_stuck = label in DOWN.values()
        if self.is_reached and self._meant() > Level.UNCONFIGURED:
            self.problem = ""

    def check_timeouts(self, heartbeat_timeout: float, respawn_window: float, now: float) -> None:
        """Record elapsed timeouts; to be called regularly.

        :param heartbeat_timeout: longest time between two heartbeats [s]
        :param respawn_window: longest absence of a lost node [s]
        """
        pause, self._checked_at = now - self._checked_at, now
        for member in self.members:
            if pause > PAUSE_S:  # no heartbeats could be received
                member.heard_at = min(now, member.heard_at + pause)
            if member.is_heard and now - member.heard_at > heartbeat_timeout:
                self.mark_lost(member, f"no heartbeat for {heartbeat_timeout:g} s", now)
        if self.goal is None:
            if (
                all(member.rests for member in self.members)
                or now - self._goal_set_at > FIRST_QUERY_S
            ):
                self._adopt_found_state(now)
        elif self.goal > Level.UNCONFIGURED:
            for member in self.members:
                if member.is_overdue(self._goal_set_at, respawn_window, now):
                    where = (
                        f"has been {state_text(member.state)} for longer than {respawn_window:g} s"
                    )
                    self._fail(f"{member.name} {where}: all others stay down until commanded")

    # Consequences.

    def ask_next(self, now: float) -> Optional[NodeState]:
        """Return the next node to send a request to, which is then pending; None for none."""
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
        """Return the result of a command, None while it runs; to be called after all requests.

        :returns: whether all nodes have reached the goal, and a message
        """
        goal = self.goal
        if goal is None or any(member.under_way for member in self.members):
            return None
        if goal > Level.UNCONFIGURED and not all(member.rests for member in self.members):
            return None
        is_good = self.is_reached and not self.problem
        summary = self.summary
        if goal is Level.GONE:  # nodes started from now on are new
            self.goal = Level.UNCONFIGURED
        return is_good, summary

    @property
    def levels(self) -> List[Level]:
        """Levels of the nodes, in order."""
        return [member.level for member in self.members]

    @property
    def is_reached(self) -> bool:
        """Whether all nodes have reached the goal."""
        return not self._others()

    @property
    def is_active(self) -> bool:
        """Whether all nodes are active, and active is the goal."""
        return self.goal is Level.ACTIVE and self.is_reached

    @property
    def summary(self) -> str:
        """Status of the nodes as text."""
        if self.problem:
            return self.problem
        if self.is_reached:
            return f"all are {state_text(self.goal or 4)}"
        return ", ".join(f"{each.name} is {state_text(each.state)}" for each in self._others())

    def _others(self) -> List[NodeState]:
        """Return the nodes that have not reached the goal."""
        return [each for each in self.members if each.is_moving or each.level != self.goal]

    def _meant(self) -> Level:
        """Return the goal, or the level at which the nodes were found."""
        return self.goal if self.goal is not None else max(Level.UNCONFIGURED, min(self.levels))

    def _adopt_found_state(self, now: float) -> None:
        """Adopt the level that was found as the goal; with autostart, ACTIVE if unconfigured."""
        self.goal, self._goal_set_at = self._meant(), now
        if self._autostart and self.goal is Level.UNCONFIGURED:
            self.goal = Level.ACTIVE

    def _fail(self, problem: str) -> None:
        """Bring all nodes down, and keep them there until the next command."""
        self.goal = min(self._meant(), Level.UNCONFIGURED)
        self.problem = problem
