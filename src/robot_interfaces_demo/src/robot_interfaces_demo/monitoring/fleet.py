"""Fleet of robots, which are discovered from their messages; independent of ROS."""

from typing import Dict, Iterable, List, Sequence, Tuple

from robot_interfaces_demo.monitoring.presence import Presence
from robot_interfaces_demo.monitoring.problems import Level
from robot_interfaces_demo.monitoring.robot import Finding, Note, Robot
from robot_interfaces_demo.monitoring.settings import LONGEST_NAME, FleetMonitorParameters, is_name

#: Most notes returned at a time.
MOST_NOTES = 10
#: Time until stopped simulated time is reported, by the machine's clock [s].
STILL_S = 5.0
#: How long ignored messages are reported [s].
IGNORED_S = 60.0
#: Columns of the table for each robot, besides name, level and message.
_COLUMNS = ("presence", "age", "period", "mode", "battery", "temperature", "obstacle")


class Fleet:
    """State of all robots, from their messages and their silence.

    The number of robots is limited by the settings, and that of notes by :data:`MOST_NOTES`; the
    rest is counted.

    :param settings: limits and other parameters
    :param now: time [s], on the same scale as all later times

    :ivar still_s: how long the time has been stopped, by the machine's clock [s]
    """

    def __init__(self, settings: FleetMonitorParameters, now: float) -> None:
        self._robots: Dict[str, Robot] = {}
        self._notes: List[Note] = []
        self._more = 0
        self._found = 0
        self._is_full = False
        #: Number of ignored messages and time of the last one, by reason.
        self._ignored: Dict[str, Tuple[int, float]] = {}
        self.still_s = 0.0
        self.set(settings, now)

    @property
    def robots(self) -> List[Robot]:
        """All robots, by name."""
        return sorted(self._robots.values(), key=lambda robot: robot.name)

    def set(self, settings: FleetMonitorParameters, now: float) -> None:
        """Change the settings.

        :param settings: the new settings
        :param now: time [s]
        """
        self._settings = settings
        expected = set(settings.expected)
        for name in expected - set(self._robots):
            self._robots[name] = Robot(name, now)
        for robot in list(self._robots.values()):
            robot.is_expected = robot.name in expected
            if not (robot.is_expected or robot.was_seen):
                del self._robots[robot.name]
        self._found = sum(not robot.is_expected for robot in self._robots.values())

    def add_message(
        self, name: str, publisher: str, mode: int, readings: Sequence[float], now: float
    ) -> None:
        """Record a message.

        :param name: of the robot
        :param publisher: name of the sending node
        :param mode: number of the robot's mode
        :param readings: as in the message
        :param now: time [s]
        """
        robot = self._robots.get(name)
        if robot is None:
            why = self._reason_against(name)
            if why:
                self._ignore(why, name, now)
                return
            robot = self._robots[name] = Robot(name, now)
            self._found += 1
        self._add_notes(robot.add_message(publisher, mode, readings, now, self._settings))

    def check_ages(self, now: float) -> None:
        """Record changes that follow from time alone.

        :param now: time [s]
        """
        self._is_full = False
        for why, (_, last) in list(self._ignored.items()):
            if now - last > IGNORED_S:
                del self._ignored[why]
        for robot in list(self._robots.values()):
            self._add_notes(robot.check_age(now, self._settings))
            if robot.age(now) > self._settings.forget_after and self._is_dispensable(robot):
                self._forget(robot)

    def notes(self) -> List[Note]:
        """Return the notes since the last call, oldest first."""
        notes, more = self._notes, self._more
        self._notes, self._more = [], 0
        if more:
            notes.append(Note(Level.WARN, f"... and {more} more; ~report has all"))
        return notes

    def findings(self, now: float) -> List[Finding]:
        """Return the condition of the fleet, then of each robot.

        :param now: time [s]
        """
        findings = [robot.finding(now, self._settings) for robot in self.robots]
        return [self._summary(findings), *findings]

    def _summary(self, findings: List[Finding]) -> Finding:
        count = len(findings)
        values = {"robots": str(count)}
        for presence in Presence:
            there = sum(robot.presence is presence for robot in self._robots.values())
            values[presence.value] = str(there)
        wrong = [finding.name for finding in findings if finding.level is not Level.OK]
        parts = [f"{count} robot{'' if count == 1 else 's'}, {len(wrong) or 'nothing'} wrong"]
        if not count:
            parts = ["no message from any robot"]
        elif wrong:
            rest = ", ..." if len(wrong) > MOST_NOTES else ""
            parts[0] += f": {', '.join(wrong[:MOST_NOTES])}{rest}"
        own = [
            f"messages ignored: {number}, as {why}" for why, (number, _) in self._ignored.items()
        ]
        if self.still_s > STILL_S:
            own.append("simulated time is stopped, so no robot becomes stale")
        level = max([Level.OK, *(finding.level for finding in findings)])
        if own or not count:
            level = max(level, Level.WARN)
        return Finding("", level, "; ".join(parts + own), values)

    def _reason_against(self, name: str) -> str:
        """Return why a new robot is ignored; empty if it is not."""
        if not is_name(name):
            return f"a name must be 1 to {LONGEST_NAME} printable characters"
        return "" if self._make_room() else f"max_robots is {self._settings.max_robots}"

    def _make_room(self) -> bool:
        """Return whether there is room for another robot, removing a lost one if necessary."""
        if self._found < self._settings.max_robots:
            return True
        if not self._is_full:  # no robot becomes lost before the next check
            lost = next(filter(self._is_dispensable, self._robots.values()), None)
            self._is_full = lost is None
            if lost is not None:
                self._forget(lost)
        return not self._is_full

    def _ignore(self, why: str, name: str, now: float) -> None:
        if why not in self._ignored:
            text = f"{name[:LONGEST_NAME]!r} and others are ignored: {why}"
            self._add_notes([Note(Level.WARN, text)])
        self._ignored[why] = (self._ignored.get(why, (0, 0.0))[0] + 1, now)

    @staticmethod
    def _is_dispensable(robot: Robot) -> bool:
        return robot.presence is Presence.LOST and not robot.is_expected

    def _forget(self, robot: Robot) -> None:
        del self._robots[robot.name]
        self._found -= 1

    def _add_notes(self, notes: Iterable[Note]) -> None:
        for note in notes:
            if len(self._notes) < MOST_NOTES:
                self._notes.append(note)
            else:
                self._more += 1


def as_table(findings: Sequence[Finding]) -> str:
    """Return findings as lines of text with aligned columns.

    :param findings: of the fleet, then of each robot
    """
    fleet, *robots = findings
    rows: List[List[str]] = [["robot", "level", *_COLUMNS, "message"]]
    for name, level, message, values in robots:
        cells = (values.get(column, "-") for column in _COLUMNS)
        rows.append([name, level.name, *cells, message])
    widths = [max(map(len, column)) for column in zip(*rows)]
    lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows if robots]
    return "\n".join([*lines, f"{fleet.level.name}: {fleet.message}"])
