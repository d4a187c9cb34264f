"""What waits: nothing that is kept is lost, and of streams the newest values come."""

import threading
from typing import Any, List

from hypothesis import given
from hypothesis import strategies as st

from serial_link.host.mailbox import DEPTH, MOST_KEPT, Mailbox


def fetch_all(mailbox: Mailbox) -> List[Any]:
    found = []
    while True:
        message = mailbox.fetch(0.0)
        if message is None:
            return found
        found.append(message)


@given(st.lists(st.one_of(st.none(), st.integers(0, 3), st.just("fetch")), max_size=120))
def test_every_schedule(steps: List[Any]) -> None:
    mailbox, kept, sent, found = Mailbox(), [], {}, []
    for number, step in enumerate(steps):
        if step is None:
            mailbox.keep(("kept", number))
            kept.append(("kept", number))
        elif step == "fetch":
            message = mailbox.fetch(0.0)
            found += [message] if message is not None else []
        else:
            mailbox.put(step, (step, number))
            sent.setdefault(step, []).append((step, number))
    found += fetch_all(mailbox)
    assert [one for one in found if one[0] == "kept"] == kept
    came = 0
    for stream, values in sent.items():
        heard = [one for one in found if one[0] == stream]
        came += len(heard)
        assert heard == sorted(heard) and heard[-1] == values[-1]  # in order, and the newest
    assert came + mailbox.dropped == sum(map(len, sent.values()))


def test_few_values_that_come_together_all_come_and_one_more_leaves_the_newest() -> None:
    mailbox = Mailbox()
    for value in range(DEPTH):
        mailbox.put("a", value)
    assert fetch_all(mailbox) == list(range(DEPTH)) and mailbox.dropped == 0
    for value in range(DEPTH + 1):
        mailbox.put("a", value)
    assert fetch_all(mailbox) == [DEPTH] and mailbox.dropped == DEPTH


def test_a_stream_may_have_a_depth_of_its_own() -> None:
    mailbox = Mailbox(depth=2)
    for value in range(3):
        mailbox.put("deep", value, depth=3)
        mailbox.put("other", value)
    assert fetch_all(mailbox) == [0, 2, 1, 2] and mailbox.dropped == 2


def test_streams_take_turns_behind_what_is_kept() -> None:
    mailbox = Mailbox()
    for value in range(3):
        mailbox.put("a", f"a{value}")
    mailbox.put("b", "b0")
    mailbox.keep("kept")
    assert fetch_all(mailbox) == ["kept", "a0", "b0", "a1", "a2"]


def test_far_too_many_are_refused_and_counted() -> None:
    mailbox = Mailbox()
    assert all(mailbox.keep(number) for number in range(MOST_KEPT))
    assert not mailbox.keep("one more")
    assert mailbox.refused == 1 and len(fetch_all(mailbox)) == MOST_KEPT


def test_what_is_cleared_does_not_come_nor_count() -> None:
    mailbox = Mailbox()
    mailbox.keep(1)
    mailbox.put("a", 2)
    mailbox.clear()
    assert fetch_all(mailbox) == [] and mailbox.dropped == 0


def test_who_waits_gets_what_comes_and_nothing_at_the_end() -> None:
    mailbox, found = Mailbox(), []
    waiting = threading.Thread(target=lambda: found.append(mailbox.fetch(30.0)))
    waiting.start()
    mailbox.put("a", "came")
    waiting.join(30.0)
    assert found == ["came"]
    waiting = threading.Thread(target=lambda: found.append(mailbox.fetch(30.0)))
    waiting.start()
    mailbox.close()
    waiting.join(30.0)
    assert found == ["came", None]
