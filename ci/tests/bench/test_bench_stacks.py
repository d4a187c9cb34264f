"""Stacks of ci/bench in Python, run with the workspace's nodes, in turns."""

import contextlib
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


def test_each_stack_answers_its_samples_in_its_turns(bench, monkeypatch):
    monkeypatch.setattr(latency, "TURN_S", 0.3)
    with contextlib.ExitStack() as stack:
        prepare = latency.at(RATE)
        turns = [stack.enter_context(prepare(bench, name)) for name in (stacks.OURS, stacks.ROSPY)]
        for turn in turns + turns[::-1]:
            figures = turn()
            assert figures["samples"] > 10
            assert figures["lost"] == 0 and figures["p50_us"] > 0.0
            assert figures["cpu_percent"] > 0.0


def test_a_pair_is_recorded_from_any_host_and_sends_nothing_while_paused(bench, tmp_path):
    file = tmp_path / "seen"
    with stacks.up(bench.session, stacks.OURS, RATE) as pair:
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
        sent = {sample.value for sample in pair.sent()}
    assert {sample.value for sample in record.read(file)} <= sent
