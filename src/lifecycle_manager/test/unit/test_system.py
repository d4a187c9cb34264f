"""Knowledge and requests of the manager, with simulated nodes."""

from typing import Callable, Dict, List, NamedTuple, Optional, Tuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lifecycle_manager.commands import COMMANDS, validated
from lifecycle_manager.node_state import GET_STATE, RESULTS, NodeState, state_text
from lifecycle_manager.plan import DOWN, Level
from lifecycle_manager.system import FIRST_QUERY_S, System

TIMEOUT_S, WINDOW_S = 0.8, 10.0
STARTUP, PAUSE, RESUME, RESET, SHUTDOWN, CONFIGURE, CLEANUP = range(7)
#: Resulting state of each transition.
STARTS = {"configure": (1,), "activate": (2,), "deactivate": (3,), "cleanup": (2,)}
#: Steps of the simulated time, time that a node takes to answer, and between two heartbeats [s].
TICK_S, ANSWER_S, BEAT_S = 0.05, 0.05, 0.2


class Fake:
    """A node as it is in truth."""

    def __init__(self) -> None:
        self.state, self.told, self.is_stopped = 1, 0, False
        self.wrong_since: Optional[float] = None

    def make(self, label: str) -> None:
        """Make a transition, if that is allowed."""
        if self.state in STARTS.get(label, (1, 2, 3)):
            self.state = RESULTS[label]


class Asked(NamedTuple):
    label: str
    due: float


class World:
    """A manager's knowledge of some nodes, and these nodes."""

    def __init__(self, count: int, autostart: bool = True) -> None:
        self.now = 100.0
        self.system = System([f"/{place}" for place in range(count)], autostart, self.now)
        self.fakes: List[Optional[Fake]] = [Fake() for _ in range(count)]
        self.asked: Dict[int, Asked] = {}
        self.steps: List[str] = []
        self.fails: Callable[[int, str], bool] = lambda place, label: False
        self.longest_wrong = 0.0
        self._beats_at = 0.0

    def member(self, place: int) -> NodeState:
        return self.system.members[place]

    def run(self, seconds: float) -> None:
        """Let time pass."""
        until = self.now + seconds
        while self.now < until - TICK_S / 2:
            self.now += TICK_S
            self._beat()
            self._tell()
            self._answer()
            self.system.check_timeouts(TIMEOUT_S, WINDOW_S, self.now)
            self._ask()
            self._check_order()

    def command(self, number: int) -> Optional[Tuple[bool, str]]:
        """Give a command, and wait for its result."""
        self.system.command(number, self.now)
        for _ in range(1000):
            self.run(TICK_S)
            result = self.system.settle()
            if result is not None:
                return result
        return None

    def kill(self, place: int, is_noticed: bool = True) -> None:
        """Kill a node; usually its connection reveals that."""
        self.fakes[place] = None
        self.asked.pop(place, None)
        if is_noticed and self.member(place).is_heard:
            self.system.mark_lost(self.member(place), "it has ended", self.now)
        elif self.member(place).under_way:
            self.system.record_answer(self.member(place), 0, "hung up", self.now)

    def _beat(self) -> None:
        if self.now < self._beats_at:
            return
        self._beats_at = self.now + BEAT_S
        for place, fake in enumerate(self.fakes):
            if fake is not None and not fake.is_stopped:
                self.system.record_heartbeat(self.member(place), self.now)

    def _tell(self) -> None:
        """Let the nodes publish new states."""
        for place, fake in enumerate(self.fakes):
            if fake is not None and not fake.is_stopped and fake.told != fake.state:
                fake.told = fake.state
                self.system.record_state(self.member(place), fake.state, self.now)

    def _answer(self) -> None:
        for place, (label, due) in list(self.asked.items()):
            fake, member = self.fakes[place], self.member(place)
            if member.under_way != label:
                del self.asked[place]  # it was lost meanwhile
            elif fake is not None and not fake.is_stopped and due <= self.now:
                del self.asked[place]
                if label != GET_STATE and not self.fails(place, label):
                    fake.make(label)
                self.system.record_answer(member, fake.state, "", self.now)

    def _ask(self) -> None:
        member = self.system.ask_next(self.now)
        while member is not None:
            place, label = self.system.members.index(member), member.under_way
            self.asked[place] = Asked(label, self.now + ANSWER_S)
            if self.fakes[place] is None:
                del self.asked[place]
                self.system.record_answer(member, 0, "no node offers it", self.now)
            elif label != GET_STATE:
                self.steps.append(f"{place} {label}")
                self._may(place, label)
            member = self.system.ask_next(self.now)

    def _may(self, place: int, label: str) -> None:
        """Check whether a step is allowed, by the known states."""
        levels = self.system.levels
        asked = [each.under_way for each in self.system.members]
        assert sum(each in DOWN.values() for each in asked) <= 1, asked
        if label == "activate":
            assert all(level >= Level.INACTIVE for level in levels), (place, levels)
            assert all(level is Level.ACTIVE for level in levels[:place])
        if label == "configure":
            assert all(level >= Level.INACTIVE for level in levels[:place]), (place, levels)

    def _check_order(self) -> None:
        """Record for how long a node is active while one before it is not configured."""
        is_sound = True
        for fake in self.fakes:
            if fake is not None and not fake.is_stopped and fake.state == 3 and not is_sound:
                fake.wrong_since = self.now if fake.wrong_since is None else fake.wrong_since
                self.longest_wrong = max(self.longest_wrong, self.now - fake.wrong_since)
            elif fake is not None:
                fake.wrong_since = None
            is_sound = is_sound and fake is not None and fake.state in (2, 3)


def up(count: int = 3) -> World:
    """Return a world in which all are active, with an empty record."""
    world = World(count)
    world.run(3.0)
    assert world.system.is_active
    del world.steps[:]
    return world


def test_up_in_order() -> None:
    world = World(2)
    world.run(2.0)
    assert world.steps == ["0 configure", "1 configure", "0 activate", "1 activate"]
    assert (world.system.is_active, world.system.summary) == (True, "all are active")


def test_no_request_before_states_are_known() -> None:
    world = World(2)
    world.fakes[1] = None
    world.run(FIRST_QUERY_S - 0.1)
    assert (world.system.goal, world.steps, world.system.settle()) == (None, [], None)
    assert world.system.summary == "/0 is unconfigured, /1 is absent"
    world.run(0.5)
    assert world.steps == ["0 configure"]
    world.fakes[1] = Fake()
    world.run(2.0)
    assert world.system.is_active


@pytest.mark.parametrize("autostart", [True, False])
@pytest.mark.parametrize(
    "states, goal",
    [((3, 3), 3), ((2, 2), 2), ((3, 2), 2), ((1, 1), None), ((3, 1), None), ((2, 4), None)],
)
def test_manager_adopts_found_states(
    states: Tuple[int, ...], goal: Optional[int], autostart: bool
) -> None:
    world = World(2, autostart)
    for fake, state in zip(world.fakes, states):
        assert fake is not None
        fake.state = state
    world.run(FIRST_QUERY_S + 0.1)
    assert world.system.goal == (goal or (3 if autostart else 1))
    if goal and len(set(states)) == 1:
        assert not world.steps


def test_a_loss_and_a_return() -> None:
    world = up()
    world.kill(1)
    assert world.system.problem == "/1 is lost: it has ended"
    assert not (world.member(1).is_heard or world.system.is_active)
    world.run(1.0)
    assert world.steps == ["2 deactivate", "0 deactivate", "2 cleanup"]
    assert world.system.settle() is None  # it is waited for
    world.fakes[1] = Fake()
    world.run(1.5)
    assert world.steps[3:] == [
        "1 configure",
        "2 configure",
        *(f"{each} activate" for each in "012"),
    ]
    assert (world.system.is_active, world.system.problem) == (True, "")


def test_a_silence() -> None:
    world = up()
    fake = world.fakes[2]
    assert fake is not None
    fake.is_stopped = True
    world.run(TIMEOUT_S - BEAT_S)
    assert not world.steps
    world.run(BEAT_S + 2 * TICK_S)
    assert world.system.problem == "/2 is lost: no heartbeat for 0.8 s"
    assert world.steps[:1] == ["1 deactivate"]
    fake.is_stopped = False
    world.run(1.0)
    assert world.steps[2:] == ["2 deactivate", "0 activate", "1 activate", "2 activate"]


def test_its_own_pauses_do_not_count() -> None:
    world = up()
    world.now += 5.0
    world.system.check_timeouts(TIMEOUT_S, WINDOW_S, world.now)
    assert world.system.problem == ""
    world.run(1.0)
    assert world.system.is_active and not world.steps


def test_unnoticed_restart_of_a_node() -> None:
    world = up()
    world.fakes[0] = Fake()
    world.run(1.5)
    assert world.steps[:3] == ["2 deactivate", "1 deactivate", "2 cleanup"]
    assert world.system.is_active


def test_missing_node_keeps_others_down() -> None:
    world = up()
    world.kill(0)
    world.run(WINDOW_S - 0.2)
    assert world.system.goal is Level.ACTIVE
    world.run(0.5)
    text = "/0 has been absent for longer than 10 s: all others stay down until commanded"
    assert (world.system.goal, world.system.problem) == (Level.UNCONFIGURED, text)
    world.fakes[0] = Fake()
    world.run(5.0)
    assert world.system.levels == [Level.UNCONFIGURED] * 3
    assert world.system.problem == text
    assert world.command(STARTUP) == (True, "all are active")


def test_loss_of_unconfigured_node_is_not_a_problem() -> None:
    world = up()
    assert world.command(PAUSE) == (True, "all are inactive")
    assert not world.system.is_active
    assert world.command(RESET) == (True, "all are unconfigured")
    world.kill(1)
    world.run(2 * WINDOW_S)
    assert world.system.problem == ""
    assert world.system.summary == "/1 is absent"


def test_finalized_node_has_to_be_restarted() -> None:
    world = up(2)
    assert world.command(SHUTDOWN) == (True, "all are finalized")
    assert world.steps == [
        "1 deactivate",
        "0 deactivate",
        "1 cleanup",
        "0 cleanup",
        "1 shutdown",
        "0 shutdown",
    ]
    world.kill(1)
    world.fakes[1] = Fake()
    world.run(1.0)
    assert world.steps[6:] == []  # it stays as it is
    result = world.command(STARTUP)
    assert result is not None and result[1].startswith("/0 has been finalized for longer than 10 s")


def test_failure_brings_nodes_down_in_order() -> None:
    world = World(3, False)
    world.run(1.0)
    world.fails = lambda place, label: (place, label) == (1, "activate")
    text = "/1: activate failed: it is inactive; its log says why"
    assert world.command(STARTUP) == (False, text)
    assert world.steps[3:] == [
        "0 activate",
        "1 activate",
        "0 deactivate",
        "2 cleanup",
        "1 cleanup",
        "0 cleanup",
    ]
    world.run(20.0)
    assert world.system.problem == text and len(world.steps) == 9
    world.fails = lambda place, label: False
    assert world.command(STARTUP) == (True, "all are active")


def test_node_that_refuses_to_be_deactivated() -> None:
    world = up()
    world.fails = lambda place, label: (place, label) == (2, "deactivate")
    text = "/2: deactivate failed: it is active; its log says why"
    assert world.command(PAUSE) == (False, text)
    assert world.steps == ["2 deactivate", "1 deactivate", "0 deactivate"]
    # Those before it stay configured until it is inactive, by whatever way.
    fake = world.fakes[2]
    assert fake is not None
    fake.state = 2
    world.run(1.0)
    assert world.steps[3:] == ["2 cleanup", "1 cleanup", "0 cleanup"]


def test_stuck_node_is_requested_again_on_command() -> None:
    world = up(1)
    world.fails = lambda place, label: True
    result = world.command(RESET)
    assert result is not None and not result[0]
    world.fails = lambda place, label: False
    assert world.command(RESET) == (True, "all are unconfigured")


def test_busy_node_is_queried_repeatedly() -> None:
    world = World(2, False)
    fake = world.fakes[0]
    assert fake is not None
    fake.state = 10
    world.run(FIRST_QUERY_S + 0.1)
    assert world.system.summary == "/0 is in transition"
    world.system.command(STARTUP, world.now)
    world.run(1.0)
    assert world.steps == []
    fake.state = 2
    world.run(1.0)
    assert world.system.is_active


@pytest.mark.parametrize("told", [[2], [3, 2], [2, 3]])
def test_state_published_before_older_answer_is_not_missed(told: List[int]) -> None:
    world = up(2)
    member, fake = world.member(1), world.fakes[1]
    assert fake is not None
    member.query_at = world.now
    assert world.system.ask_next(world.now) is member
    fake.state = fake.told = told[-1]
    for state in told:
        world.system.record_state(member, state, world.now)
    world.system.record_answer(member, 3, "", world.now)
    world.run(1.0)
    assert world.steps == ["1 activate"] * (told[-1] == 2)
    assert world.system.is_active and fake.state == 3


def test_a_transition_without_an_answer_has_failed() -> None:
    world = World(1)
    member, fake = world.member(0), world.fakes[0]
    assert fake is not None
    while member.under_way != "configure":
        world.run(TICK_S)
    world.asked.clear()
    fake.state = 10
    world.system.record_answer(member, 10, "no answer within 5 s", world.now)
    assert world.system.problem == "/0: configure failed: no answer within 5 s"
    fake.state = 2
    world.run(1.0)
    assert world.steps == ["0 configure", "0 cleanup"]


def test_node_that_shuts_down_during_request_may_come_back() -> None:
    world = up(2)
    for state in (12, 4):
        world.system.command(PAUSE, world.now)
        world.run(TICK_S)
        assert world.member(1).under_way == "deactivate"
        fake = world.fakes[1]
        assert fake is not None
        fake.state = state
        world.run(0.5)
        assert world.system.problem == ""
        world.kill(1)
        world.fakes[1] = Fake()
        world.run(2.0)
        assert world.system.settle() == (True, "all are inactive")
        assert world.command(RESUME) == (True, "all are active")


def test_commands() -> None:
    for number, command in enumerate(COMMANDS):
        for meant in Level:
            if meant in command.starts:
                assert validated(number, meant) is command
            else:
                with pytest.raises(
                    ValueError, match=f"^{command.name} is refused while all are to be"
                ):
                    validated(number, meant)
    with pytest.raises(ValueError, match="command: refused 7: must be one of 0 STARTUP, 1 PAUSE"):
        validated(7, Level.ACTIVE)


def test_states() -> None:
    member = NodeState("/a", 0.0)
    found = []
    for state in (*range(5), *range(10, 16)):
        member.enter(state, 0.0)
        found.append((state, int(member.level), member.is_moving))
    assert found == [
        (0, 0, False),
        (1, 1, False),
        (2, 2, False),
        (3, 3, False),
        (4, 0, False),
        (10, 1, True),
        (11, 1, True),
        (12, 0, True),
        (13, 3, True),
        (14, 3, True),
        (15, 0, True),
    ]
    assert [state_text(state) for state in (0, 3, 4, 10)] == [
        "absent",
        "active",
        "finalized",
        "in transition",
    ]


def test_never_seen_node_is_not_lost() -> None:
    world = World(2)
    world.fakes[1] = None
    world.system.command(STARTUP, world.now)
    world.run(5.0)
    assert world.system.problem == ""
    assert world.system.summary == "/0 is inactive, /1 is absent"


def test_node_with_heartbeat_but_without_answers() -> None:
    world = World(2)
    world.run(0.2)
    world.system.command(STARTUP, world.now)
    for _ in range(60):
        world.now += 0.2
        for place, state in enumerate((0, 1)):
            world.system.record_heartbeat(world.member(place), world.now)
            if world.member(place).under_way:
                world.system.record_answer(world.member(place), state, "", world.now)
        world.system.check_timeouts(TIMEOUT_S, WINDOW_S, world.now)
        world.system.ask_next(world.now)
    assert world.system.problem.startswith("/0 has been absent for longer than 10 s")


EVENTS = st.tuples(
    st.sampled_from(["killed", "killed unseen", "started", "stopped", "continued"]),
    st.integers(0, 3),
    st.sampled_from([0.05, 0.1, 0.3, 1.0, 2.0]),
)


@settings(deadline=None, max_examples=150)
@given(st.integers(1, 4), st.lists(EVENTS, max_size=12))
def test_random_losses(count: int, events: List[Tuple[str, int, float]]) -> None:
    """A wrong order lasts no longer than it takes to notice and to undo it."""
    world = World(count)
    world.run(1.0)
    for kind, place, pause in events:
        place %= count
        fake = world.fakes[place]
        if kind.startswith("killed"):
            world.kill(place, is_noticed=kind == "killed")
        elif kind == "started" and fake is None:
            world.fakes[place] = Fake()
        elif fake is not None:
            fake.is_stopped = kind == "stopped"
        world.run(pause)
    # One step for each node that is active, and one more that may be under way.
    assert world.longest_wrong <= TIMEOUT_S + BEAT_S + (count + 1) * (ANSWER_S + 2 * TICK_S)
    for place, fake in enumerate(world.fakes):
        if fake is None:
            world.fakes[place] = Fake()
        else:
            fake.is_stopped = False
    world.system.command(STARTUP, world.now)  # some may have been away for too long
    world.run(3.0)
    assert world.system.is_active, world.system.summary
