"""What is counted."""

from serial_link.host.counts import RECEIVED, SENT, Counts


def test_counts_add_up_by_name() -> None:
    counts = Counts()
    assert counts.all() == {}
    counts.add(SENT)
    counts.add(SENT, 3)
    counts.add(RECEIVED, 2)
    assert counts.all() == {SENT: 4, RECEIVED: 2}
