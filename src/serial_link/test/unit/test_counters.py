"""Counters."""

from serial_link.host.counters import RECEIVED, SENT, Counters


def test_counts_add_up_by_name() -> None:
    counts = Counters()
    assert counts.to_dict() == {}
    counts.add(SENT)
    counts.add(SENT, 3)
    counts.add(RECEIVED, 2)
    assert counts.to_dict() == {SENT: 4, RECEIVED: 2}
