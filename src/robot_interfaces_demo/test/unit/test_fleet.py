"""Any number of robots."""

import math
from typing import Any, Dict, List, Sequence, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nodekit import ParameterError
from robot_interfaces_demo.monitoring.fleet import MOST_NOTES, Fleet, as_table
from robot_interfaces_demo.monitoring.problems import Level
from robot_interfaces_demo.monitoring.robot import Finding
from robot_interfaces_demo.monitoring.settings import FleetMonitorParameters

FINE = (12.0, 25.0, 1.0)


class Rig:
    """A fleet, and a clock."""

    def __init__(self, **settings: Any) -> None:
        self.now = 0.0
        self.fleet = Fleet(FleetMonitorParameters(**settings), 0.0)

    def set(self, **settings: Any) -> None:
        self.fleet.set(FleetMonitorParameters(**settings), self.now)

    def send(
        self, name: str, mode: int = 0, readings: Sequence[float] = FINE, publisher: str = ""
    ) -> None:
        self.fleet.add_message(name, publisher or f"/{name}", mode, readings, self.now)

    def run(self, seconds: float, *names: str, **options: Any) -> List[str]:
        """Advance the time, with a message of each robot each second; return the notes."""
        for _ in range(round(seconds)):
            self.now += 1.0
            for name in names:
                self.send(name, **options)
            self.fleet.check_ages(self.now)
        return self.told()

    def told(self) -> List[str]:
        """Return the notes as lines."""
        return [f"{note.level.name} {note.text}" for note in self.fleet.notes()]

    def findings(self) -> Dict[str, Finding]:
        """Return how each is, by name."""
        return {finding.name: finding for finding in self.fleet.findings(self.now)}

    def message(self, name: str = "") -> Tuple[Level, str]:
        """Return the condition of a robot."""
        return self.findings()[name].level, self.findings()[name].message


def test_robots_become_stale_then_lost_then_return() -> None:
    rig = Rig()
    assert rig.message() == (Level.WARN, "no message from any robot")
    assert rig.run(10, "a", "b") == ["OK a: present", "OK b: present"]
    assert rig.message() == (Level.OK, "2 robots, nothing wrong")
    assert rig.run(3, "a") == []
    assert rig.run(1, "a") == ["WARN b: stale, no message for 4.0 s"]
    assert rig.message() == (Level.WARN, "2 robots, 1 wrong: b")
    assert rig.run(6, "a") == []
    assert rig.run(1, "a") == ["ERROR b: lost, no message for 11.0 s"]
    assert rig.message("b") == (Level.ERROR, "lost")
    assert rig.message() == (Level.ERROR, "2 robots, 1 wrong: b")
    assert rig.run(3, "a", "b") == ["WARN b: returning"]
    assert rig.message("b") == (Level.WARN, "returning")
    assert rig.run(1, "a", "b") == ["OK b: present"]
    assert rig.message() == (Level.OK, "2 robots, nothing wrong")


def test_a_period_that_is_given_is_taken_for_all() -> None:
    rig = Rig(period=5.0)
    rig.run(10, "a")
    assert rig.run(15) == []
    assert rig.run(1) == ["WARN a: stale, no message for 16.0 s"]


def test_expected_robot_is_reported_before_first_message() -> None:
    rig = Rig(expected=["a", "b"], longest_period=2.0)
    assert rig.message() == (Level.WARN, "2 robots, 2 wrong: a, b")
    assert rig.run(6, "a") == ["OK a: present"]
    assert rig.run(1, "a") == ["ERROR b: never seen, no message for 7.0 s"]
    assert rig.message("b") == (Level.ERROR, "never seen")
    assert "mode" not in rig.findings()["b"].values
    rig.set(expected=["a", "c"])  # while it runs
    assert set(rig.findings()) == {"", "a", "c"}
    rig.set()
    assert set(rig.findings()) == {"", "a"}


def test_one_message_is_enough_to_be_seen() -> None:
    rig = Rig(expected=["a", "b"])
    rig.send("a")
    assert rig.findings()["a"].values["messages"] == "1"
    rig.set()
    assert set(rig.findings()) == {"", "a"}


def test_two_publishers_of_one_name_are_an_error_until_one_remains() -> None:
    rig = Rig()
    rig.run(3, "a")
    for publisher in ("/x", "/a", "/x", "/a"):
        rig.run(1, "a", publisher=publisher)
    assert rig.message("a") == (Level.ERROR, "several nodes publish under this name")
    assert rig.findings()["a"].values["publisher"] == "/a, /x"
    assert rig.run(20, "a") == ["OK a: one node publishes under this name again"]
    assert rig.message() == (Level.OK, "1 robot, nothing wrong")


def test_publishers_are_kept_for_lost_after_periods() -> None:
    rig = Rig(period=2.0)
    rig.send("a")
    rig.run(15, "a", publisher="/x")
    assert rig.message("a")[0] is Level.OK
    rig.run(1, "a")  # /a was heard 16 s before
    assert rig.message("a")[0] is Level.ERROR
    rig.run(19, "a")  # /x was heard 20 s before
    assert rig.message("a")[0] is Level.ERROR
    rig.run(1, "a")
    assert rig.message("a")[0] is Level.OK


def test_two_publishers_are_logged_once_with_names() -> None:
    rig = Rig()
    for _ in range(5):
        rig.run(1, "a")
        rig.send("a", publisher="/x")
    text = "ERROR a: several nodes publish under this name: /a, /x"
    rig.send("a")
    assert rig.told() == []
    rig = Rig()
    rig.send("a")
    rig.send("a", publisher="/x")
    rig.send("a")
    rig.send("a", publisher="/x")
    assert rig.told() == ["OK a: present", text]


@pytest.mark.parametrize(
    "mode, readings, text",
    [
        (9, FINE, "unknown mode 9"),
        (0, (12.0,), "readings are missing: 1 of 3 received"),
        (0, (12.0, math.nan, 1.0), "a reading is not finite: temperature nan"),
        (0, (12.0, 25.0, -math.inf), "a reading is not finite: obstacle -inf"),
    ],
)
def test_defect_is_logged_once_per_robot_and_shown_while_present(
    mode: int, readings: Sequence[float], text: str
) -> None:
    rig = Rig()
    rig.run(3, "a", "b")
    for _ in range(3):
        rig.run(1, "a", "b")
        rig.send("a", mode, readings)
    assert rig.message("a") == (Level.WARN, text)
    rig.send("b", mode, readings)
    assert rig.told() == [f"WARN b: {text}"]
    assert rig.run(1, "a", "b") == []
    assert rig.message() == (Level.OK, "2 robots, nothing wrong")


def test_defect_is_logged() -> None:
    rig = Rig()
    for _ in range(3):
        rig.send("a", 9)
        rig.send("a")
    assert rig.told() == ["OK a: present", "WARN a: unknown mode 9"]


def test_warning_is_logged_at_start_and_end() -> None:
    rig = Rig()
    rig.run(1, "a")
    for _ in range(2):
        rig.send("a", 0, (10.5, 25.0, 1.0))
        rig.send("a", 0, (10.5, 25.0, 1.0))
        assert rig.message("a") == (Level.WARN, "battery is low: 10.50 V")
        rig.send("a")
        assert rig.told() == [
            "WARN a: battery is low: 10.50 V",
            "OK a: cleared: battery is low",
        ]
    rig.send("a", 4, (12.0, 50.0, 0.1))
    error = "error mode, too hot: 50.00 °C, obstacle is near: 0.10 m"
    assert rig.message("a") == (Level.ERROR, error)


def test_a_limit_may_be_changed_while_it_runs() -> None:
    rig = Rig()
    rig.run(1, "a")
    rig.set(battery_low=12.5)
    rig.send("a")
    assert rig.message("a") == (Level.WARN, "battery is low: 12.00 V")


def test_surplus_robots_are_ignored_and_logged_once() -> None:
    rig = Rig(max_robots=2, expected=["late"])
    rig.now = 1000.0
    for name in ("a", "b", "c", "d", "late"):
        rig.send(name)
    told = rig.told()
    assert told[2:] == [
        "WARN 'c' and others are ignored: max_robots is 2",
        "OK late: present",
    ]
    assert set(rig.findings()) == {"", "a", "b", "late"}
    text = "3 robots, nothing wrong; messages ignored: 2, as max_robots is 2"
    assert rig.message() == (Level.WARN, text)
    rig.run(60, "a", "late")
    assert rig.message()[1].endswith("ignored: 2, as max_robots is 2")
    rig.run(1, "a", "late")
    assert "left out" not in rig.message()[1]
    rig.run(40, "a", "late")
    assert rig.message() == (Level.ERROR, "3 robots, 1 wrong: b")  # as no robot was removed since
    rig.send("c")  # b is lost, and gives way
    assert set(rig.findings()) == {"", "a", "c", "late"}
    rig.send("d")
    assert rig.told()[-1] == "WARN 'd' and others are ignored: max_robots is 2"


def test_long_lost_robot_is_removed_unless_expected() -> None:
    rig = Rig(forget_after=60.0, expected=["a"], max_robots=1)
    rig.run(5, "a", "b")
    rig.run(59)
    assert set(rig.findings()) == {"", "a", "b"}
    rig.run(2)
    assert set(rig.findings()) == {"", "a"}
    assert rig.message("a") == (Level.ERROR, "lost")
    rig.run(1, "b")
    assert rig.message("b") == (Level.OK, "present")


@pytest.mark.parametrize("name", ["", " a", "a\n", "x" * 65, "a\x1b[31m", "\ud800"])
def test_invalid_name_is_ignored_and_logged_once(name: str) -> None:
    rig = Rig()
    rig.send(name)
    rig.send(name)
    (line,) = rig.told()
    assert line.endswith("ignored: a name must be 1 to 64 printable characters")
    assert line.isprintable()
    assert set(rig.findings()) == {""}
    with pytest.raises(ParameterError, match="printable|without control characters"):
        FleetMonitorParameters(expected=[name])


@given(st.lists(st.tuples(st.text(max_size=3), st.integers(0, 6)), max_size=60))
def test_memory_is_bounded_whatever_the_names_are(heard: List[Tuple[str, int]]) -> None:
    rig = Rig(max_robots=5, expected=["a"], period=1.0, forget_after=20.0)
    for name, seconds in heard:
        rig.send(name, 7, [math.nan] * 1000, publisher=f"/{seconds}")
        rig.now += seconds
        rig.fleet.check_ages(rig.now)
        assert len(rig.findings()) <= 1 + 5 + 1
    assert len(rig.told()) <= MOST_NOTES + 1
    assert rig.told() == []


def test_first_lines_are_logged_and_rest_counted() -> None:
    rig = Rig()
    for number in range(25):
        rig.send(f"robot_{number:02d}")
    told = rig.told()
    assert told[:2] == ["OK robot_00: present", "OK robot_01: present"]
    assert told[10:] == ["WARN ... and 15 more; ~report has all"]
    assert rig.run(31)[10:] == ["WARN ... and 15 more; ~report has all"]
    assert rig.message()[1].endswith("robot_09, ...")
    values = rig.findings()[""].values
    assert values.pop("robots") == values.pop("stale") == "25"
    assert set(values.values()) == {"0"}
    rig = Rig(expected=[f"robot_{number}" for number in range(MOST_NOTES)])
    assert rig.message()[1].endswith("robot_9")


def test_stopped_clock_is_reported() -> None:
    rig = Rig()
    rig.run(3, "a")
    rig.fleet.still_s = 5.0
    assert rig.message() == (Level.OK, "1 robot, nothing wrong")
    rig.fleet.still_s = 5.1
    text = "1 robot, nothing wrong; simulated time is stopped, so no robot becomes stale"
    assert rig.message() == (Level.WARN, text)


def test_the_table_has_a_line_for_each_robot_and_one_for_the_fleet() -> None:
    rig = Rig(expected=["b"], longest_period=1.0)
    rig.run(4, "a", mode=1)
    lines = as_table(rig.fleet.findings(rig.now)).splitlines()
    assert lines[0].startswith("robot  level  presence    age    period  mode  ")
    assert lines[1].startswith("a      OK     present     0.0 s  1.00 s  moving")
    assert lines[0].endswith("  mode    battery  temperature  obstacle  message")
    assert lines[1].endswith("  moving  12.00 V  25.00 °C     1.00 m    present")
    assert lines[2].startswith("b      ERROR  never seen  4.0 s  -       -       -        -  ")
    assert lines[3:] == ["ERROR: 2 robots, 1 wrong: b"]
    assert as_table(Rig().fleet.findings(0.0)) == "WARN: no message from any robot"


def test_stale_is_never_later_than_lost() -> None:
    with pytest.raises(ParameterError, match="stale_after must be at most lost_after"):
        FleetMonitorParameters(stale_after=5.0, lost_after=4.0)
