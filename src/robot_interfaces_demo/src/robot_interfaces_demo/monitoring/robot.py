"""State of one robot."""

import math
from typing import Dict, FrozenSet, Iterator, List, NamedTuple, Sequence, Set

from robot_interfaces_demo.modes import name_of
from robot_interfaces_demo.monitoring.period import PeriodLearner
from robot_interfaces_demo.monitoring.presence import Attendance, Presence
from robot_interfaces_demo.monitoring.problems import (
    DEFECTS,
    LIMITS,
    READINGS,
    Level,
    Problem,
    find_problems,
)
from robot_interfaces_demo.monitoring.publishers import Publishers
from robot_interfaces_demo.monitoring.settings import FleetMonitorParameters

#: Severity of each state.
LEVELS: Dict[Presence, Level] = {
    Presence.AWAITED: Level.WARN,
    Presence.NEVER_SEEN: Level.ERROR,
    Presence.PRESENT: Level.OK,
    Presence.STALE: Level.WARN,
    Presence.LOST: Level.ERROR,
    Presence.RETURNING: Level.WARN,
}


class Note(NamedTuple):
    """A change to log.

    :param level: severity
    :param text: description
    """

    level: Level
    text: str


class Finding(NamedTuple):
    """Condition of a robot, or of the fleet.

    :param name: of the robot, empty for the fleet
    :param level: severity
    :param message: summary
    :param values: details by name
    """

    name: str
    level: Level
    message: str
    values: Dict[str, str]


class Robot:
    """One robot.

    :param name: its name
    :param now: time [s]

    :ivar is_expected: whether its absence is a problem
    """

    def __init__(self, name: str, now: float) -> None:
        self.name = name
        self.is_expected = False
        self._attendance = Attendance(Presence.AWAITED, now)
        self._period = PeriodLearner()
        self._publishers = Publishers()
        self._problems: FrozenSet[Problem] = frozenset()
        self._logged_defects: Set[Problem] = set()
        self._mode = 0
        self._count = 0
        self._readings: Sequence[float] = ()

    @property
    def presence(self) -> Presence:
        """Presence of the robot."""
        return self._attendance.state

    @property
    def was_seen(self) -> bool:
        """Whether a message of it has ever arrived."""
        return self._count > 0

    @property
    def problems(self) -> FrozenSet[Problem]:
        """Current problems."""
        if self._publishers.has_rivals:
            return self._problems | {Problem.TWO_PUBLISHERS}
        return self._problems

    @property
    def level(self) -> Level:
        """Highest severity of presence and problems."""
        return max([LEVELS[self.presence], *(problem.level for problem in self.problems)])

    def age(self, now: float) -> float:
        """Return the time since its last message, or since it is expected [s]."""
        return self._attendance.age(now)

    def period(self, settings: FleetMonitorParameters) -> float:
        """Return the time between its messages [s]."""
        return settings.period or self._period.period(settings.longest_period)

    def check_age(self, now: float, settings: FleetMonitorParameters) -> List[Note]:
        """Record changes that follow from time alone.

        :param now: time [s]
        :param settings: current settings
        :returns: changes
        """
        before, had_rivals = self.presence, self._publishers.has_rivals
        period = self.period(settings)
        self._attendance.check_age(now, settings.stale_after * period, settings.lost_after * period)
        self._publishers.forget(now, settings.lost_after * period)
        news = []
        if had_rivals and not self._publishers.has_rivals:
            news.append(Note(Level.OK, f"{self.name}: one node publishes under this name again"))
        if self.presence is not before:
            news.append(self._change(f", no message for {self.age(now):.1f} s"))
        return news

    def add_message(
        self,
        publisher: str,
        mode: int,
        readings: Sequence[float],
        now: float,
        settings: FleetMonitorParameters,
    ) -> List[Note]:
        """Record a message.

        :param publisher: name of the sending node
        :param mode: number of the mode
        :param readings: as in the message
        :param now: time [s]
        :param settings: current settings
        :returns: changes
        """
        before, had_rivals = self.presence, self._publishers.has_rivals
        period = self.period(settings)
        self._attendance.add_message(
            now, settings.stale_after * period, settings.lost_after * period
        )
        self._period.add_arrival(now, settings.longest_period)
        self._publishers.add_message(publisher, now, settings.lost_after * period)
        problems = find_problems(mode, readings, self._problems, settings)
        was, self._problems = self._problems, problems
        self._mode = mode
        self._readings = readings[:READINGS]
        self._count = self._count + 1
        news = [self._change("")] if self.presence is not before else []
        if self._publishers.has_rivals and not had_rivals:
            text = (
                f"{self.name}: {Problem.TWO_PUBLISHERS.text}: {', '.join(self._publishers.names())}"
            )
            news.append(Note(Level.ERROR, text))
        if problems != was:
            news += self._news(was, problems)
        return news

    def finding(self, now: float, settings: FleetMonitorParameters) -> Finding:
        """Return the robot's condition.

        :param now: time [s]
        :param settings: current settings
        """
        texts = [self.presence.value, *(self._text(p) for p in Problem if p in self.problems)]
        if self.presence is Presence.PRESENT and len(texts) > 1:
            del texts[0]
        values = {"presence": self.presence.value, "age": f"{self.age(now):.1f} s"}
        if self.was_seen:
            values["period"] = f"{self.period(settings):.2f} s"
            values["mode"] = name_of(self._mode)
            for limit, reading in zip(LIMITS, self._readings):
                values[limit.name] = f"{reading:.2f} {limit.unit}"
            values["messages"] = str(self._count)
            values["publisher"] = ", ".join(self._publishers.names())
        return Finding(self.name, self.level, ", ".join(texts), values)

    def _change(self, more: str) -> Note:
        return Note(LEVELS[self.presence], f"{self.name}: {self.presence.value}{more}")

    def _news(self, was: FrozenSet[Problem], now: FrozenSet[Problem]) -> Iterator[Note]:
        for problem in Problem:
            if problem in now and problem not in was and problem not in self._logged_defects:
                if problem in DEFECTS:
                    self._logged_defects.add(problem)
                yield Note(problem.level, f"{self.name}: {self._text(problem)}")
            elif problem in was and problem not in now and problem not in DEFECTS:
                yield Note(Level.OK, f"{self.name}: cleared: {problem.text}")

    def _text(self, problem: Problem) -> str:
        if problem is Problem.UNKNOWN_MODE:
            return f"{problem.text} {self._mode}"
        if problem is Problem.SHORT:
            return f"{problem.text}: {len(self._readings)} of {READINGS} received"
        for limit, reading in zip(LIMITS, self._readings):
            if problem is Problem.NOT_FINITE and not math.isfinite(reading):
                return f"{problem.text}: {limit.name} {reading}"
            if problem is limit.problem:
                return f"{problem.text}: {reading:.2f} {limit.unit}"
        return problem.text
