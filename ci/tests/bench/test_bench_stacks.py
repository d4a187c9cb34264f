"""Tests that a stack of ci/bench that is written after the workspace's nodes runs with them."""

import pathlib

import pytest
import stacks
from analysis import match_in_order
from peers import Peers
from processes import Session

RATE = 100.0


@pytest.fixture(scope="module", name="session")
def make_session(tmp_path_factory):
    with Session(tmp_path_factory.mktemp("session")) as session:
        yield session


@pytest.mark.parametrize("stack", [stacks.OURS, stacks.MANAGED])
def test_each_answer_belongs_to_a_sample_that_was_recorded(session, stack):
    nothing_else = Peers(pathlib.Path(), None, None, {})
    run = stacks.run(session, nothing_else, stack, RATE, seconds=0.5, warm_up=0.2)
    sent = [sample.moment for sample in run.sent]
    received = [sample.moment for sample in run.received]
    matched = match_in_order(sent, received, run.until)
    assert len(received) > 10
    assert len(matched.latencies) == len(received)
    assert matched.lost == 0
