"""Tests of the pool of segments, with numbers in place of memory and readers."""

from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from nodekit.shared_memory.segment_pool import IDLE_S, SegmentPool, capacity_for

LIMIT = 100_000_000
SIZES = st.integers(0, 64_000_000)


class FakeMemory:
    """Memory that knows its size only."""

    def __init__(self, size):
        self.size, self.is_open = size, True

    def close(self):
        assert self.is_open
        self.is_open = False


class Pools(RuleBasedStateMachine):
    """A pool, and a record of the segments that each reader may be reading."""

    def __init__(self):
        super().__init__()
        self.made = []
        self.is_full, self.now = False, 0.0
        self.pool = SegmentPool(self.create, LIMIT)
        self.lent = []  # segments, once for each reader

    def create(self, size):
        if self.is_full:
            raise OSError("no memory")
        self.made.append(FakeMemory(size))
        return self.made[-1]

    @rule(size=SIZES, readers=st.integers(1, 4), is_full=st.booleans())
    def publish(self, size, readers, is_full):
        self.is_full = is_full
        segment = self.pool.take(size, self.now)
        if segment is None:
            taken = sum(one.memory.size for one in set(self.lent))
            assert is_full or taken + capacity_for(size) > LIMIT
            return
        assert segment not in self.lent
        assert segment.memory.size >= size and segment.memory.is_open
        segment.users += readers
        self.lent += [segment] * readers

    @precondition(lambda self: self.lent)
    @rule(data=st.data())
    def read(self, data):
        segment = self.lent.pop(data.draw(st.integers(0, len(self.lent) - 1)))
        segment.users -= 1

    @rule(wait=st.floats(0.0, 3.0 * IDLE_S))
    def trim(self, wait):
        self.now += wait
        self.pool.trim(self.now)
        if wait >= IDLE_S:
            assert set(self.pool.numbers()) == {segment.number for segment in self.lent}

    @invariant()
    def has_what_is_lent_and_no_more_than_allowed(self):
        assert self.pool.size == sum(one.size for one in self.made if one.is_open) <= LIMIT
        assert all(segment.memory.is_open for segment in self.lent)

    def teardown(self):
        self.pool.close()
        assert not any(one.is_open for one in self.made)


test_segments_are_written_only_while_nobody_reads_them = Pools.TestCase


def test_segment_is_used_again_once_its_readers_have_returned_it():
    pool = SegmentPool(FakeMemory)
    first = pool.take(1000, 0.0)
    first.users = 1
    second = pool.take(1000, 0.0)
    assert second is not first
    first.users, second.users = 0, 1
    assert pool.take(1000, 1.0) is first
    assert pool.numbers() == [1, 2]


def test_small_message_leaves_a_larger_segment_to_larger_ones():
    pool = SegmentPool(FakeMemory)
    large = pool.take(10_000_000, 0.0)
    large.users = 1
    small = pool.take(1000, 0.0)
    large.users = 0
    assert pool.take(1000, 0.0) is small


@given(SIZES)
def test_capacity_has_some_room_and_little_waste(size):
    capacity = capacity_for(size)
    assert size <= capacity <= max(size * 1.125, size + 65_536)


def test_capacity_of_growing_messages_changes_seldom():
    assert len({capacity_for(size) for size in range(4_000_000, 8_000_000, 1000)}) <= 9
