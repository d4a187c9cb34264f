"""Tests of the evaluation of mutants: selection, order and time limits of tests."""

import os
import pathlib
import signal
import sys
import threading
import time
from types import SimpleNamespace
from typing import Iterator, List

import pytest

from ci.mutation import evaluation
from ci.mutation.evaluation import Evaluation
from ci.tiers.steps import Step

MODULE = "p/src/p/a.py"
TEXT = "def f() -> int:\n    return 1\n"
OTHER = '<test pkg="p" type="test_good.py" test-name="good" time-limit="30"/>'
ROSTEST = f"""<launch>
  <group>
    {OTHER}
    <test pkg="p" type="test_value.py" test-name="value" time-limit="30"/>
  </group>
</launch>
"""
TEST = """#!/usr/bin/env python3
import unittest
import rosunit
from p.a import f

class Value(unittest.TestCase):
    def test_it(self):
        self.assertIn(f(), (1, 3))

rosunit.unitrun("p", "value", Value)
"""


@pytest.fixture
def sources(tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch") -> pathlib.Path:
    """Return a folder with a package ``p`` of one module, in place of the workspace's."""
    for name in ("PYTHONPATH", "ROS_PACKAGE_PATH", "PYTHONPYCACHEPREFIX", evaluation.FAIL_FAST):
        monkeypatch.setenv(name, os.environ.get(name, ""))  # set by the tested code
    monkeypatch.setattr(evaluation, "SOURCES", tmp_path / "src")
    module = tmp_path / "src" / MODULE
    module.parent.mkdir(parents=True)
    module.write_text(TEXT)
    (module.parent / "__init__.py").write_text("")
    manifest = "<package><name>p</name><version>1.0.0</version></package>"
    (tmp_path / "src" / "p" / "package.xml").write_text(manifest)
    return tmp_path / "src"


@pytest.fixture
def handlers() -> Iterator[None]:
    """Restore the handlers of signals."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def run(sources: pathlib.Path, handlers: None, tmp_path: pathlib.Path) -> Iterator[Evaluation]:
    started = Evaluation(tmp_path, True)
    yield started
    started.close()
    assert not (tmp_path / "copy").exists() and not (tmp_path / "compiled").exists()


def offer(monkeypatch: "pytest.MonkeyPatch", **commands: str) -> None:
    """Replace the integration tests by Python commands."""
    steps = [
        Step("integration", name, [sys.executable, "-c", command])
        for name, command in commands.items()
    ]
    monkeypatch.setattr(evaluation, "integration_steps", lambda _: steps)


def killers(run: Evaluation, *values: str) -> List[str]:
    """Return the names of the tests that detect some values in place of 1."""
    found = [run.killer(MODULE, TEXT.replace("1", value)) for value in values]
    return [killer.split(":")[0] for killer in found]


def test_tests_that_import_the_module_are_run_the_shortest_first(
    run: Evaluation, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    offer(
        monkeypatch,
        long="from p.a import f; assert f() < 3",
        short="from p.a import f; assert f() in (1, 3)",
        other="assert True",
        broken="from p.a import f; assert f() == 7",
    )
    times = iter((0.0, 9.0, 10.0, 12.0, 20.0, 21.0, 30.0, 31.0))
    with monkeypatch.context() as patch:
        patch.setattr(evaluation, "time", SimpleNamespace(monotonic=lambda: next(times)))
        list(run.tests_of(MODULE))  # measures their times
    assert [step.name for step in run.tests_of(MODULE)] == ["short", "long"]
    (left_out,) = run.left_out()
    assert left_out.startswith("broken: ")
    # Of one length, and within a second: the compiled module must not be reused.
    assert killers(run, "2", "3", "1", "9") == ["short", "long", "", "short"]


def test_long_test_is_not_run_if_a_short_one_kills(
    run: Evaluation, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    offer(monkeypatch, long="assert False", short="from p.a import f; assert f() == 1")
    long, short = evaluation.integration_steps(pathlib.Path())
    steps = [long, Step("integration", "short", short.command, long.time_limit / 2)]
    monkeypatch.setattr(evaluation, "integration_steps", lambda _: steps)
    assert killers(run, "2") == ["short"] and not run.left_out()


def test_endless_mutant_is_killed_by_the_time(
    run: Evaluation, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(evaluation, "ON_TOP_S", 0.5)
    monkeypatch.setattr("ci.tiers.steps.GRACE", 0.1)
    offer(monkeypatch, it="from p.a import f; f()")
    assert run.killer(MODULE, "def f():\n    while True:\n        pass\n").startswith("it: ")


def test_random_failure_kills_no_mutant(
    run: Evaluation, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    mark = tmp_path / "mark"
    offer(
        monkeypatch,
        it=f"import os, p.a, pathlib; assert os.environ[{evaluation.FAIL_FAST!r}]\n"
        f"if not pathlib.Path({str(mark)!r}).exists():\n"
        f"    pathlib.Path({str(mark)!r}).touch(); assert False",
    )
    assert list(run.tests_of(MODULE)) and not run.left_out()
    mark.unlink()
    assert killers(run, "2") == [""]


def test_ctrl_c_ends_the_running_test_and_leaves_no_mutant(
    run: Evaluation, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    begun, ended = tmp_path / "begun", tmp_path / "ended"
    offer(
        monkeypatch,
        it="import pathlib, time; from p.a import f\nif f() == 2:\n"
        "    try:\n"
        f"        pathlib.Path({str(begun)!r}).touch()\n"
        "        time.sleep(60)\n"
        f"    finally: pathlib.Path({str(ended)!r}).touch()",
    )
    list(run.tests_of(MODULE))

    def interrupt() -> None:
        while not begun.exists():
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        run.killer(MODULE, TEXT.replace("1", "2"))
    assert ended.exists() and (tmp_path / "copy" / "src" / MODULE).read_text() == TEXT


def test_unit_test_and_rostest_notice_mutants_in_the_copy(
    sources: pathlib.Path, handlers: None, tmp_path: pathlib.Path
) -> None:
    unit, place = sources / "p" / "test" / "unit", sources / "p" / "test" / "integration"
    for folder in (unit, place):
        folder.mkdir(parents=True)
    (unit / "test_a.py").write_text("from p.a import f\n\ndef test_it():\n    assert f() != 2\n")
    (place / "it.test").write_text(ROSTEST.replace(OTHER, ""))
    (place / "test_value.py").write_text(TEST)
    (place / "test_value.py").chmod(0o755)
    run = Evaluation(tmp_path, True)
    assert killers(run, "2", "4") == ["p/unit test_a", "p/it value"], run.left_out()
    assert (sources / MODULE).read_text() == TEXT
    run.close()


def test_part_of_a_rostest_has_one_test_node_and_all_others(tmp_path: pathlib.Path) -> None:
    place = tmp_path / "p" / "test" / "extended"
    place.mkdir(parents=True)
    (place / "it.test").write_text(ROSTEST.replace("<group>", "<group><node/>"))
    steps = evaluation.integration_steps(tmp_path / "p")
    assert [(step.name, step.time_limit) for step in steps] == [
        ("p/it good", 90),
        ("p/it value", 90),
    ]
    for step, type_ in zip(steps, ("test_good.py", "test_value.py")):
        text = pathlib.Path(step.command[-1]).read_text()
        assert text.count("<test ") == 1 and type_ in text and "<node" in text


def test_only_tests_with_a_browser_open_the_page() -> None:
    steps = evaluation.integration_steps(evaluation.SOURCES / "topic_scope")
    pages = {step.name for step in steps if step.tier == "page"}
    for step in steps:
        pathlib.Path(step.command[-1]).unlink()
    assert pages and all(" page" in name for name in pages if "browser" in name)
    assert not [name for name in pages if "/scope " in name or "guards" in name]
