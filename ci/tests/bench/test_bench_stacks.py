"""Tests that the stacks of ci/bench in Python run with the workspace's nodes, in turns."""

import contextlib
import pathlib
import signal

import pytest

from ci.benchmark import latency, machine, record, robots, stacks, throughput, timing
from ci.benchmark.context import Bench
from ci.benchmark.observers import wait_until
from ci.benchmark.peer_programs import Peers, find_relay, module
from ci.benchmark.processes import Session

RATE = 100.0


@pytest.fixture(scope="module", name="bench")
def make_bench(tmp_path_factory):
    with Session(tmp_path_factory.mktemp("session")) as session:
        yield Bench(session, Peers(pathlib.Path(), None, None, {}), True)


def test_a_machine_without_dpkg_is_described(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert machine.describe()["rospy"] == "not from a package"


def test_the_relay_is_that_of_the_ros_that_is_built_upon(tmp_path, monkeypatch):
    relay = tmp_path / "ros" / "lib" / "topic_tools" / "relay"
    relay.parent.mkdir(parents=True)
    relay.touch()
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"{tmp_path / 'devel'}:{tmp_path / 'ros'}")
    assert find_relay() == relay


def test_each_answers_its_samples_in_its_turns_and_stands_still_in_those_of_others(bench):
    names = [stacks.OURS, stacks.MANAGED, stacks.HOST]
    stand_ready = latency.in_turns(RATE)
    with contextlib.ExitStack() as stack:
        turns = [stack.enter_context(stand_ready(bench, name)) for name in names]
        for turn in turns + turns[::-1]:
            figures = turn()
            assert figures["samples"] > 10
            assert figures["lost"] == 0 and figures["p50_us"] > 0.0
            assert figures["cpu_percent"] > 0.0


def test_a_pair_of_stock_rospy_answers(bench):
    with stacks.up(bench.session, bench.peers, stacks.ROSPY, RATE) as pair:
        run = stacks.watch(pair, 0.0, 0.5)
    assert len(latency.answered(run).latencies) > 10


def test_a_topic_is_recorded_from_any_host_until_ctrl_c(bench, tmp_path):
    file = tmp_path / "seen"
    with stacks.up(bench.session, bench.peers, stacks.OURS, RATE) as pair:
        with bench.session.node() as node:
            published = [name for name, _ in node.master("getPublishedTopics", "")]
        (topic,) = [name for name in published if name.endswith("/signal")]
        command = module("endurance.observe", topic, "basic_comms/signal_msg", str(file))
        observer = bench.session.start(command)
        underway = file.with_suffix(".new")
        wait_until(lambda: underway.exists() and record.read(underway), 30.0, "samples")
        observer.send_signal(signal.SIGINT)
        assert observer.wait(30.0) == 0
        sent = {sample.value for sample in pair.sent()}
    assert {sample.value for sample in record.read(file)} <= sent


def test_nothing_is_waited_for_without_end(bench, monkeypatch):
    monkeypatch.setattr(timing, "PATIENCE_S", 0.1)
    monkeypatch.setattr(stacks, "generator_command", lambda *_arguments: ["sleep", "600"])
    with pytest.raises(TimeoutError, match="no sample"):
        timing.over_time(bench, stacks.OURS)


def test_a_source_that_ends_is_told_of(bench, monkeypatch):
    monkeypatch.setattr(throughput, "signal_msg_md5sum", lambda: "*")
    monkeypatch.setattr(
        stacks, "peer", lambda script, *rest: ["sh", "-c", "read line; echo 'no luck' >&2"]
    )
    with pytest.raises(RuntimeError, match="source has ended: no luck"):
        throughput.zero_loss_rate(bench, stacks.OURS)


def test_robots_are_alone_first_and_all_of_them_heard_then(bench, monkeypatch):
    heard = []

    def look(_pids, _seconds):
        with bench.session.node() as node:
            _, subscribed, _ = node.master("getSystemState")
        heard.append(sorted(topic for topic, _ in subscribed if topic.startswith("/robot")))
        return 1.0

    monkeypatch.setattr(robots, "cpu_share", look)
    monkeypatch.setattr(robots, "COUNT", 2)
    topics = [f"/robot{number}/{topic}" for number in (1, 2) for topic in ("joint_states", "odom")]
    commands = [f"/robot{number}/cmd_vel" for number in (1, 2)]
    robots.measure(bench, robots.FLEET)
    assert heard == [commands, sorted(commands + topics)]


def test_a_pair_that_stands_still_sends_nothing(bench):
    with stacks.up(bench.session, bench.peers, stacks.OURS, RATE) as pair:
        with latency.standing(pair.pids):
            before = len(pair.sent())
            stacks.watch(pair, 0.0, 0.3)
            assert len(pair.sent()) == before
        assert len(stacks.watch(pair, 0.0, 0.3).sent) > before
