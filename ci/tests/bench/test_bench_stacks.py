"""Tests of the Python stacks of ci/bench."""

import pytest

from ci.benchmark import latency, stacks
from ci.benchmark.context import Bench
from ci.benchmark.processes import Session, paused

RATE = 100.0


@pytest.fixture(scope="module", name="bench")
def make_bench(tmp_path_factory):
    with Session(tmp_path_factory.mktemp("session")) as session:
        yield Bench(session, is_quick=True)


def test_a_pair_answers_its_samples_in_its_turns(bench, monkeypatch):
    monkeypatch.setattr(latency, "TURN_S", 0.3)
    with latency.at(RATE)(bench, stacks.OURS) as turn:
        for _ in range(2):
            figures = turn()
            assert figures["samples"] > 10
            assert figures["lost"] == 0 and figures["p50_us"] > 0.0
            assert figures["cpu_percent"] > 0.0


def test_a_peer_answers_and_sends_nothing_while_paused(bench):
    with stacks.up(bench.session, stacks.ROSPY, RATE) as pair:
        run = stacks.watch(pair, 0.0, 0.3)
        assert len(latency.answered(run).latencies) > 10
        with paused(pair.pids):
            before = len(pair.sent())
            stacks.watch(pair, 0.0, 0.1)
            assert len(pair.sent()) == before
