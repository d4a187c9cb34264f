"""Next request of the manager."""

import itertools
from typing import List, Set, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lifecycle_manager.plan import DOWN, UP, Level, highest, next_instruction

GONE, UNCONFIGURED, INACTIVE, ACTIVE = Level
LEVELS = st.lists(st.sampled_from(Level), min_size=1, max_size=5)
LETTERS = dict(zip("-uia", Level))


def levels(text: str) -> List[Level]:
    return [LETTERS[letter] for letter in text]


def way(goal: Level, start: str) -> str:
    """Return all steps, each done immediately, as "1 configure", counted from 1."""
    now, steps = levels(start), []
    step = next_instruction(goal, now)
    while step is not None:
        steps.append(f"{step.place + 1} {step.label}")
        now[step.place] = Level(now[step.place] + (1 if step.label in UP.values() else -1))
        step = next_instruction(goal, now)
    return ", ".join(steps)


@pytest.mark.parametrize(
    "goal, start, expected",
    [
        (ACTIVE, "uu", "1 configure, 2 configure, 1 activate, 2 activate"),
        (INACTIVE, "uu", "1 configure, 2 configure"),
        (INACTIVE, "aa", "2 deactivate, 1 deactivate"),
        (UNCONFIGURED, "aa", "2 deactivate, 1 deactivate, 2 cleanup, 1 cleanup"),
        (UNCONFIGURED, "iu", "1 cleanup"),
        (GONE, "iu", "1 cleanup, 2 shutdown, 1 shutdown"),
        # After a loss, the nodes after it come down, those before it do not.
        (ACTIVE, "a-a", "3 deactivate, 1 deactivate, 3 cleanup"),
        (ACTIVE, "-aa", "3 deactivate, 2 deactivate, 3 cleanup, 2 cleanup"),
        (ACTIVE, "aa-", "2 deactivate, 1 deactivate"),
        # It is back.
        (
            ACTIVE,
            "iuu",
            "2 configure, 3 configure, 1 activate, 2 activate, 3 activate",
        ),
        # It had only been stopped, and is still active.
        (ACTIVE, "iia", "3 deactivate, 1 activate, 2 activate, 3 activate"),
        (ACTIVE, "-", ""),
        (ACTIVE, "-u", ""),
        (ACTIVE, "u-", "1 configure"),
    ],
)
def test_way(goal: Level, start: str, expected: str) -> None:
    assert way(goal, start) == expected


def test_no_node_goes_up_during_a_transition() -> None:
    for what in ("configure", "get_state"):
        assert next_instruction(ACTIVE, levels("uu"), {0: what}) is None


def test_node_goes_down_during_transition_up_of_another() -> None:
    assert next_instruction(ACTIVE, levels("-ai"), {2: "activate"}) == (1, "deactivate")
    assert next_instruction(ACTIVE, levels("-aa"), {2: "deactivate"}) is None


def test_stuck_node_keeps_its_dependencies() -> None:
    assert next_instruction(UNCONFIGURED, levels("aaa"), stuck=[2]) == (1, "deactivate")
    assert next_instruction(UNCONFIGURED, levels("iia"), stuck=[2]) is None
    assert next_instruction(UNCONFIGURED, levels("iii"), stuck=[2]) == (1, "cleanup")


@given(LEVELS, st.sampled_from(Level))
def test_steps_always_reach_the_goal(start: List[Level], goal: Level) -> None:
    now = list(start)
    for _ in range(2 * 3 * len(now)):
        step = next_instruction(goal, now)
        if step is None:
            break
        place, is_up = step.place, step.label in UP.values()
        assert step.label == (UP if is_up else DOWN)[now[place]]
        if step.label == "activate":
            assert all(level >= INACTIVE for level in now)
        if step.label == "configure":
            assert all(level >= INACTIVE for level in now[:place])
        now[place] = Level(now[place] + (1 if is_up else -1))
    assert next_instruction(goal, now) is None
    assert all(level <= highest(place, goal, now) for place, level in enumerate(now))
    if GONE not in start:
        assert now == [goal] * len(now)


#: A place of at most twelve, which all counts up to four divide, and what happens there.
EVENTS = st.tuples(st.integers(0, 11), st.sampled_from(["killed", "back", "step", "step", "step"]))


@given(st.integers(1, 4), st.lists(EVENTS, min_size=40, max_size=40))
def test_no_node_is_active_before_its_predecessors_are_configured(
    count: int, events: List[Tuple[int, str]]
) -> None:
    """Random losses and returns, detected immediately: only a loss violates the order, briefly."""
    now = [UNCONFIGURED] * count
    for where, event in events:
        place = where % count
        if event == "killed" and now[place] is not GONE:
            now[place] = GONE
        elif event == "back" and now[place] is GONE:
            now[place] = UNCONFIGURED
        before = _wrong(now)
        step = next_instruction(ACTIVE, now)
        if step is not None:
            delta = 1 if step.label in UP.values() else -1
            now[step.place] = Level(now[step.place] + delta)
        assert _wrong(now) <= before, (step, now)
        if step is None:
            assert not _wrong(now)


def _wrong(now: List[Level]) -> Set[Tuple[int, int]]:
    """Return the pairs of which the first is not configured while the second is active."""
    pairs = itertools.combinations(range(len(now)), 2)
    return {(one, two) for one, two in pairs if now[one] < INACTIVE and now[two] is ACTIVE}
