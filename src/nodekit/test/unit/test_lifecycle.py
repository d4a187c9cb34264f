"""Tests of the state machine of managed nodes: each cell of its table, and invariants."""

import itertools
import threading
from typing import List, Optional, Tuple, Union

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lifecycle_msgs.msg import State as StateMessage
from lifecycle_msgs.msg import Transition as TransitionMessage
from nodekit.lifecycle_states import (
    ACTIVE,
    CONFIGURING,
    FINALIZED,
    OUTCOMES,
    REQUESTS,
    STATES,
    TRANSITIONS,
    UNCONFIGURED,
    NotAllowed,
    Outcome,
    State,
    Transition,
    available,
    requested,
)
from nodekit.managed.state_machine import StateMachine

#: Goal of each allowed request, by state and label; all others are refused.
ASKED = {
    ("unconfigured", "configure"): (1, "configuring"),
    ("unconfigured", "shutdown"): (5, "shuttingdown"),
    ("inactive", "cleanup"): (2, "cleaningup"),
    ("inactive", "activate"): (3, "activating"),
    ("inactive", "shutdown"): (6, "shuttingdown"),
    ("active", "deactivate"): (4, "deactivating"),
    ("active", "shutdown"): (7, "shuttingdown"),
}
#: Where success, failure and error lead to, as ROS 2's documentation has it.
LEADS = {
    "configuring": ("inactive", "unconfigured", "errorprocessing"),
    "cleaningup": ("unconfigured", "inactive", "errorprocessing"),
    "activating": ("active", "inactive", "errorprocessing"),
    "deactivating": ("inactive", "active", "errorprocessing"),
    "shuttingdown": ("finalized", "finalized", "errorprocessing"),
    "errorprocessing": ("unconfigured", "finalized", "finalized"),
}
LABELS = ("configure", "cleanup", "activate", "deactivate", "shutdown", "create", "destroy", "")
#: ROS 2's name of the callback that each state is about.
CALLBACKS = {
    "configuring": "CONFIGURE",
    "cleaningup": "CLEANUP",
    "activating": "ACTIVATE",
    "deactivating": "DEACTIVATE",
    "shuttingdown": "SHUTDOWN",
    "errorprocessing": "ERROR",
}


@pytest.mark.parametrize("label", LABELS)
@pytest.mark.parametrize("state", STATES, ids=lambda state: state.label)
def test_transitions_allowed_by_label(state: State, label: str) -> None:
    """Course err-7."""
    expected = ASKED.get((state.label, label))
    if expected is None:
        with pytest.raises(NotAllowed):
            requested(state, label)
    else:
        found = requested(state, label)
        assert (found.id, found.goal.label, found.start) == (*expected, state)


@pytest.mark.parametrize("state", STATES, ids=lambda state: state.label)
def test_transitions_allowed_by_id(state: State) -> None:
    allowed = {number for (start, _), (number, _) in ASKED.items() if start == state.label}
    for number in range(256):
        if number in allowed:
            assert requested(state, number).id == number
        else:
            with pytest.raises(NotAllowed):
                requested(state, number)


@pytest.mark.parametrize(
    "state, wanted, text",
    [
        (
            UNCONFIGURED,
            "activate",
            "activate is not allowed in the state unconfigured; "
            "allowed: configure [1], shutdown [5]",
        ),
        (
            ACTIVE,
            6,
            "shutdown is not allowed in the state active; allowed: deactivate [4], shutdown [7]",
        ),
        (
            FINALIZED,
            "fly",
            "transition 'fly' is not allowed in the state finalized; allowed: none",
        ),
    ],
)
def test_refusals_list_the_allowed_values(state: State, wanted: Union[int, str], text: str) -> None:
    with pytest.raises(NotAllowed) as refusal:
        requested(state, wanted)
    assert str(refusal.value) == text


@pytest.mark.parametrize("outcome", Outcome)
@pytest.mark.parametrize("state", STATES, ids=lambda state: state.label)
def test_where_callbacks_lead_to(state: State, outcome: Outcome) -> None:
    transition = OUTCOMES.get((state, outcome))
    if transition is None:
        assert state.label not in LEADS
    else:
        assert transition.start == state
        assert transition.goal.label == LEADS[state.label][list(Outcome).index(outcome)]


def test_ids_and_labels_are_those_of_the_messages() -> None:
    for state in STATES:
        kind = "PRIMARY" if state.id < 10 else "TRANSITION"
        assert getattr(StateMessage, f"{kind}_STATE_{state.label.upper()}") == state.id
    for request in REQUESTS:
        name = request.label.upper()
        if name == "SHUTDOWN":
            name = f"{request.start.label.upper()}_{name}"
        assert getattr(TransitionMessage, f"TRANSITION_{name}") == request.id
    for (state, outcome), transition in OUTCOMES.items():
        name = f"TRANSITION_ON_{CALLBACKS[state.label]}_{outcome.name}"
        assert getattr(TransitionMessage, name) == transition.id
        assert transition.label == f"transition_{outcome.name.lower()}"
    for outcome in Outcome:
        assert getattr(TransitionMessage, f"TRANSITION_CALLBACK_{outcome.name}") == outcome


def test_table_is_sound() -> None:
    assert len({transition.id for transition in TRANSITIONS}) == len(TRANSITIONS) == 7 + 6 * 3
    assert len(set(STATES)) == 11
    assert all(each.start in STATES and each.goal in STATES for each in TRANSITIONS)
    assert available(FINALIZED) == []
    assert [each.id for each in available(CONFIGURING)] == [10, 11, 12]
    for state in STATES:  # the end can be reached from everywhere but from nowhere
        reached = {state}
        for _ in STATES:
            reached |= {each.goal for each in TRANSITIONS if each.start in reached}
        assert FINALIZED in reached or state.label == "unknown"


@given(st.lists(st.tuples(st.sampled_from(LABELS[:5]), st.lists(st.sampled_from(Outcome)))))
def test_any_requests_keep_the_table(plan: List[Tuple[str, List[Outcome]]]) -> None:
    told: List[Transition] = []
    machine = StateMachine(told.append)
    for label, outcomes in plan:
        before = machine.state
        try:
            transition = machine.claim(label)
        except NotAllowed:
            assert (before.label, label) not in ASKED
            assert machine.state == before
            continue
        machine.advance(transition)
        following = itertools.chain(outcomes, itertools.repeat(Outcome.SUCCESS))
        while machine.state.id >= 10:
            machine.advance(OUTCOMES[machine.state, next(following)])
        machine.release()
    assert machine.state.id < 10
    states = [UNCONFIGURED] + [each.goal for each in told]
    assert [each.start for each in told] == states[:-1]
    assert set(told) <= set(TRANSITIONS)
    assert FINALIZED not in states[:-1]


def test_one_transition_at_a_time() -> None:
    machine = StateMachine(lambda transition: None)
    transition = machine.claim("configure")
    with pytest.raises(NotAllowed, match="^shutdown is not allowed while configure is running$"):
        machine.claim("shutdown")
    machine.advance(transition)
    with pytest.raises(NotAllowed, match="^2 is not allowed while configure is running$"):
        machine.claim(2)
    machine.advance(OUTCOMES[machine.state, Outcome.SUCCESS])
    machine.release()
    assert machine.claim(2).label == "cleanup"


def test_claim_does_not_wait_by_default(monkeypatch: "pytest.MonkeyPatch") -> None:
    machine = StateMachine(lambda step: None)
    machine.claim("configure")
    waits: List[float] = []
    monkeypatch.setattr(machine._free, "wait", waits.append)
    with pytest.raises(NotAllowed):
        machine.claim("shutdown")
    assert set(waits) <= {0.0}


def test_claim_may_wait() -> None:
    machine = StateMachine(lambda transition: None)
    machine.claim("configure")
    claimed: List[Optional[Transition]] = []
    waiting = threading.Thread(target=lambda: claimed.append(machine.claim("shutdown", 10.0)))
    waiting.start()
    machine.release()
    waiting.join(10.0)
    assert [each.id for each in claimed if each is not None] == [5]


def test_refused_claim_leaves_nothing_to_release() -> None:
    machine = StateMachine(lambda transition: None)
    for _ in range(2):
        with pytest.raises(NotAllowed, match="activate is not allowed"):
            machine.claim("activate")
    machine.claim("configure")


def test_step_from_elsewhere_is_refused() -> None:
    machine = StateMachine(lambda transition: None)
    with pytest.raises(NotAllowed, match="activate does not leave the state unconfigured"):
        machine.advance(REQUESTS[2])
    assert machine.state == UNCONFIGURED
