"""Tests of the pool of segments, with numbers in place of memory and readers."""

from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from nodekit.shared_memory.segment_pool import IDLE_S, SegmentPool, capacity_for

LIMIT = 100_000_000
SIZES = st.integers(0, 64_000_000)
READERS = st.sampled_from("abcd")


class FakeMemory:
    """Memory that knows its size only."""

    def __init__(self, size):
        self.size, self.is_open = size, True


class Pools(RuleBasedStateMachine):
    """A pool, and a record of the segments that each reader may be reading."""

    def __init__(self):
        super().__init__()
        self.made = []
        self.is_full = False
        self.pool = SegmentPool(self.create, self.discard, LIMIT)
        self.lent = set()  # pairs of a segment and a reader
        self.now = 0.0

    def create(self, size):
        if self.is_full:
            raise OSError("no memory")
        self.made.append(FakeMemory(size))
        return self.made[-1]

    def discard(self, segment):
        assert not any(lent is segment for lent, _ in self.lent)
        assert segment.memory.is_open
        segment.memory.is_open = False

    @rule(size=SIZES, readers=st.sets(READERS, min_size=1), is_full=st.booleans())
    def publish(self, size, readers, is_full):
        self.is_full = is_full
        held = {segment.number: segment for segment, _ in self.lent}
        segment = self.pool.take(size, self.now)
        if segment is None:
            taken = sum(one.capacity for one in held.values())
            assert is_full or taken + capacity_for(size) > LIMIT
            return
        assert segment.number not in held
        assert segment.capacity >= size and segment.memory.is_open
        for reader in readers:
            self.pool.lend(segment, reader)
            self.lent.add((segment, reader))

    @precondition(lambda self: self.lent)
    @rule(data=st.data())
    def read(self, data):
        order = sorted(self.lent, key=lambda one: (one[0].number, one[1]))
        segment, reader = data.draw(st.sampled_from(order))
        assert self.pool.give_back(segment.number, reader)
        self.lent.discard((segment, reader))
        assert not self.pool.give_back(segment.number, reader)

    @rule(reader=READERS)
    def leave(self, reader):
        self.pool.forget(reader)
        self.lent = {one for one in self.lent if one[1] != reader}

    @rule(wait=st.floats(0.0, 3.0 * IDLE_S))
    def trim(self, wait):
        self.now += wait
        self.pool.trim(self.now)
        if wait >= IDLE_S:
            assert len(self.pool) == len({segment for segment, _ in self.lent})

    @invariant()
    def has_what_is_lent_and_no_more_than_allowed(self):
        assert self.pool.size == sum(one.size for one in self.made if one.is_open) <= LIMIT
        assert all(segment.memory.is_open for segment, _ in self.lent)

    def teardown(self):
        self.lent = set()
        self.pool.close()
        assert not any(one.is_open for one in self.made)


test_segments_are_written_only_while_nobody_reads_them = Pools.TestCase


def test_segment_is_used_again_once_its_readers_have_returned_it():
    pool = SegmentPool(FakeMemory, lambda segment: None)
    first = pool.take(1000, 0.0)
    pool.lend(first, "reader")
    second = pool.take(1000, 0.0)
    assert second is not first
    pool.give_back(first.number, "reader")
    pool.lend(second, "reader")
    assert pool.take(1000, 1.0) is first
    assert len(pool) == 2


def test_small_message_leaves_a_larger_segment_to_larger_ones():
    pool = SegmentPool(FakeMemory, lambda segment: None)
    large = pool.take(10_000_000, 0.0)
    pool.lend(large, "reader")
    small = pool.take(1000, 0.0)
    pool.give_back(large.number, "reader")
    assert pool.take(1000, 0.0) is small


@given(SIZES)
def test_capacity_has_some_room_and_little_waste(size):
    capacity = capacity_for(size)
    assert size <= capacity <= max(size * 1.125, size + 65_536)


def test_capacity_of_growing_messages_changes_seldom():
    assert len({capacity_for(size) for size in range(4_000_000, 8_000_000, 1000)}) <= 9
