"""What a manager knows of its nodes and wants of them; it is told what happens, and the time.

Time is that of any clock that never goes back, s.
"""

import math
from typing import List, Optional, Sequence, Tuple

from lifecycle_manager.commands import judged
from lifecycle_manager.member import LOOK, RESULTS, Member, state_text
from lifecycle_manager.plan import DOWN, Level, next_step

#: Time between two looks at a node that is in the middle of something or does not answer, s.
LOOK_EVERY_S = 0.2
#: Longest time that a new manager looks at what there is, s.
FIRST_LOOK_S = 2.0
#: Time between two looks around from which on it was the manager itself that had stopped, s.
PAUSE_S = 0.3


class System:
    """The nodes in their order, and how far up they are to be.

    :param names: of the nodes, in order
    :param autostart: whether they are brought up without being told
    :param now: the time

    :ivar goal: how far up they are to be; None until it has been looked what there is
    :ivar problem: why they are not where they were told to be; empty where they are, or will be
    """

    def __init__(self, names: Sequence[str], autostart: bool, now: float) -> None:
        self.members = [Member(name, now) for name in names]
        self.goal: Optional[Level] = None
        self.problem = ""
        self._autostart = autostart
        self._told_at = self._looked_at = now

    # What happens.

    def command(self, number: int, now: float) -> None:
        """Take a command.

        :param number: of the command
        :raises ValueError: if it is none, or not one for now
        """
        self.goal, self.problem = judged(number, self._meant()).goal, ""
        self._told_at = now
        for member in self.members:
            member.is_stuck = False

    def hear(self, member: Member, now: float) -> None:
        """Note a heartbeat; a node that was not heard before is looked at."""
        member.heard_at = now
        if not member.is_heard:
            member.is_heard, member.look_at = True, now

    def tell(self, member: Member, state: int, now: float) -> None:
        """Note what a node says of its state; where that is news, look, as it may be old."""
        if member.is_heard and state != member.state and not member.under_way:
            member.look_at = now

    def lose(self, member: Member, why: str, now: float) -> None:
        """Note that a node is not there any more.

        :param why: how that was seen
        """
        member.is_heard, member.look_at, member.under_way = False, math.inf, ""
        member.enter(0, now)
        if self._meant() > Level.UNCONFIGURED:
            self.problem = f"{member.name} is lost: {why}"

    def end(self, member: Member, state: int, why: str, now: float) -> None:
        """Note what has come of what a node was asked.

        :param state: number of its state, 0 where it has not answered
        :param why: what went wrong, as far as that is known
        """
        label, member.under_way = member.under_way, ""
        member.enter(state, now)
        if member.is_moving or not state:
            member.look_at = now + LOOK_EVERY_S
        # One that has shut down meanwhile is lost rather than to blame: it may come back.
        if member.level > Level.GONE and state != RESULTS.get(label, state):
            result = why or f"it is {state_text(state)}, and its log says why"
            self._fail(f"{member.name}: {label} has failed: {result}")
            member.is_stuck = label in DOWN.values()
        if self.is_reached and self._meant() > Level.UNCONFIGURED:
            self.problem = ""

    def look_around(self, heartbeat_timeout: float, respawn_window: float, now: float) -> None:
        """Note what has not happened; to be called every now and then.

        :param heartbeat_timeout: longest time between two heartbeats, s
        :param respawn_window: longest time until a node that is not there has to be back, s
        """
        pause, self._looked_at = now - self._looked_at, now
        for member in self.members:
            if pause > PAUSE_S:  # nobody has listened meanwhile
                member.heard_at = min(now, member.heard_at + pause)
            if member.is_heard and now - member.heard_at > heartbeat_timeout:
                self.lose(member, f"no heartbeat for {heartbeat_timeout:g} s", now)
        if self.goal is None:
            if all(member.rests for member in self.members) or now - self._told_at > FIRST_LOOK_S:
                self._begin(now)
        elif self.goal > Level.UNCONFIGURED:
            for member in self.members:
                if member.is_overdue(self._told_at, respawn_window, now):
                    is_what = f"is {state_text(member.state)} for longer than {respawn_window:g} s"
                    self._fail(f"{member.name} {is_what}: all others stay down until told")

    # What follows from it.

    def ask_next(self, now: float) -> Optional[Member]:
        """Return a node that is to be asked what is noted as under way from now on, if any."""
        members = list(enumerate(self.members))
        for _, member in members:
            if not member.under_way and member.look_at <= now:
                member.under_way, member.look_at = LOOK, math.inf
                return member
        busy = {place: each.under_way or LOOK for place, each in members if each.is_busy}
        stuck = [place for place, each in members if each.is_stuck]
        step = next_step(self.goal, self.levels, busy, stuck) if self.goal is not None else None
        if step is None:
            return None
        self.members[step.place].under_way = step.label
        return self.members[step.place]

    def settle(self) -> Optional[Tuple[bool, str]]:
        """Tell what has come of a command, None where it goes on; to be asked when all were asked.

        :returns: whether all nodes are where they are to be, and a sentence
        """
        goal = self.goal
        if goal is None or any(member.under_way for member in self.members):
            return None
        if goal > Level.UNCONFIGURED and not all(member.rests for member in self.members):
            return None
        is_good, summary = self.is_reached and not self.problem, self.summary
        if goal is Level.GONE:  # who is started anew from now on is a fresh start
            self.goal = Level.UNCONFIGURED
        return is_good, summary

    @property
    def levels(self) -> List[Level]:
        """How far up the nodes are, in order."""
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
        """Where the nodes are, in words."""
        if self.problem:
            return self.problem
        if self.is_reached:
            return f"all are {state_text(self.goal or 4)}"
        return ", ".join(f"{each.name} is {state_text(each.state)}" for each in self._others())

    def _others(self) -> List[Member]:
        """Return the nodes that are not where they are to be."""
        return [each for each in self.members if each.is_moving or each.level != self.goal]

    def _meant(self) -> Level:
        """Return how far up the nodes are to be, or where they have been found."""
        return self.goal if self.goal is not None else max(Level.UNCONFIGURED, min(self.levels))

    def _begin(self, now: float) -> None:
        """Take over what there is; from unconfigured it goes up where that is wanted."""
        self.goal, self._told_at = self._meant(), now
        if self._autostart and self.goal is Level.UNCONFIGURED:
            self.goal = Level.ACTIVE

    def _fail(self, problem: str) -> None:
        """Bring all nodes down, and have them stay there until told."""
        self.goal, self.problem = min(self._meant(), Level.UNCONFIGURED), problem
