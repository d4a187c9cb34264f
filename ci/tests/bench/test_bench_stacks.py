"""Stacks of ci/bench in Python, run with the workspace's nodes, in turns."""

import signal

import pytest

from ci.benchmark import latency, record, stacks
from ci.benchmark.context import Bench
from ci.benchmark.peer_programs import module
from ci.benchmark.processes import Session, paused
from ci.benchmark.recorder import wait_until

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


def test_a_peer_answers_and_is_recorded_from_any_host_and_sends_nothing_while_paused(
    bench, tmp_path
):
    file = tmp_path / "seen"
    with stacks.up(bench.session, stacks.ROSPY, RATE) as pair:
        run = stacks.watch(pair, 0.0, 0.3)
        assert len(latency.answered(run).latencies) > 10
        with bench.session.node() as node:
            published = [name for name, _ in node.master.getPublishedTopics("")]
        (topic,) = [name for name in published if name.endswith("/signal")]
        command = module("endurance.observe", topic, "basic_comms/signal_msg", str(file))
        observer = bench.session.start(command)
        wait_until(lambda: record.read(file.with_suffix(".new")), 30.0, "samples")
        with paused(pair.pids):
            before = len(pair.sent())
            stacks.watch(pair, 0.0, 0.1)
            assert len(pair.sent()) == before
        observer.send_signal(signal.SIGINT)
        assert observer.wait(30.0) == 0
    times = [sample.value for sample in record.read(file)]
    assert times and times == sorted(times)
