"""Tests of the parser of the log of managed nodes."""

from ci.endurance.transition_log import Entry, NodeStates, entries

GOOD = [
    *((1.0, "/a", "configured"), (2.0, "/b", "configured")),
    *((3.0, "/a", "activated"), (4.0, "/b", "activated")),
]


def node_states(*more: "tuple[float, str, str]") -> NodeStates:
    found = NodeStates(("/a", "/b"))
    for entry in (*GOOD, *more):
        found.read(Entry(*entry))
    return found


def test_entries_are_sorted() -> None:
    text = "2.5 /b activated\n1.5 /a killed\n"
    assert entries(text) == [(1.5, "/a", "killed"), (2.5, "/b", "activated")]


def test_good_story_has_no_fault() -> None:
    good = node_states()
    assert (good.all_active(), good.rash, good.longest) == (True, [], 0.0)
    assert not node_states((5.0, "/b", "stopped")).all_active()
    assert not node_states((5.0, "/b", "deactivated")).all_active()


def test_stays_active_after_a_loss() -> None:
    bad = node_states((5.0, "/a", "killed"), (5.3, "/b", "deactivated"), (9.0, "/a", "started"))
    assert (round(bad.longest, 6), bad.rash) == (0.3, [])


def test_stopped_node_is_not_active() -> None:
    events = [(5.0, "/b", "stopped"), (5.1, "/a", "deactivated"), (5.2, "/a", "cleaned_up")]
    assert node_states(*events).longest == 0.0
    bad = node_states(*events, (7.0, "/b", "continued"), (7.5, "/b", "deactivated"))
    assert round(bad.longest, 6) == 0.5


def test_is_activated_too_early() -> None:
    bad = node_states((5.0, "/b", "deactivated"), (5.1, "/a", "killed"), (6.0, "/b", "activated"))
    assert bad.rash == ["/b at 6.000"]
