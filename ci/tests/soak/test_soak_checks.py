"""Tests of bounds and reports of long runs."""

import json
import os
import pathlib
import threading

import pytest

from ci.benchmark.cost import Usage, usage
from ci.benchmark.report import write_json
from ci.endurance import checks
from ci.endurance.run_record import size_of
from ci.endurance.usage import Sampler, added, growth, not_grown


def test_bounds_are_inclusive() -> None:
    assert checks.at_most("x", 2.0, 2.0).passed
    assert not checks.at_most("x", 2.1, 2.0).passed
    assert checks.at_least("x", 2.0, 2.0).passed
    assert not checks.at_least("x", 1.9, 2.0).passed
    assert checks.none_of("x", []).passed
    assert not checks.none_of("x", ["one"]).passed


def test_all_kept_needs_every_check_of_every_run() -> None:
    good, bad = checks.at_most("x", 1.0, 2.0), checks.at_most("x", 3.0, 2.0)
    assert checks.all_kept({"a": [good], "b": [good]})
    assert not checks.all_kept({"a": [good], "b": [good, bad]})
    assert not checks.all_kept({})


def test_table_marks_missed_bounds() -> None:
    of_run = [checks.at_most("gap", 3.0, 2.0, "ms"), checks.reported("load", "1.5")]
    text = checks.table({"record": of_run})
    assert "| record | gap  | <= 2 ms | 3 ms   | SHORT |" in text
    assert "| record | load |         | 1.5    |       |" in text


def test_json_holds_every_check(tmp_path: pathlib.Path) -> None:
    content = checks.as_json({"a": [checks.at_most("x", 1.0, 2.0)]}, {"cores": "2"})
    write_json(tmp_path / "out", content)
    assert json.loads((tmp_path / "out").read_text()) == content
    assert content["machine"] == {"cores": "2"}
    assert content["runs"]["a"][0]["passed"] is True


def test_growth_compares_the_ends() -> None:
    assert growth([100.0] * 50 + [101.0] * 50) == pytest.approx(1.0)
    assert growth([100.0] * 50 + [900.0] + [100.0] * 49) == 0.0
    assert growth([100.0, 98.0]) == pytest.approx(-2.0)


def test_shown_memory_is_that_whose_growth_is_checked() -> None:
    memory = [900 * 1024] + [100 * 1024] * 19 + [101 * 1024] * 18 + [900 * 1024] * 2
    seen = [Usage(kilobytes, 8, 9) for kilobytes in memory]
    shown, grown = not_grown("the node", seen, 1.0, min)[:2]
    assert (shown.figure, grown.figure) == ("100.0 MB, then 101.0 MB", "1 %")


def test_added_threads_are_those_that_stay() -> None:
    assert added([8] * 50 + [9] * 50) == 1
    assert added([8] * 45 + [12] * 10 + [8] * 45) == 0
    assert added([8] * 95 + [12] + [8] * 4) == 0


def test_usage_of_this_process() -> None:
    before = usage(os.getpid())
    done = threading.Event()
    thread = threading.Thread(target=done.wait)
    thread.start()
    with open(os.devnull):
        during = usage(os.getpid())
    done.set()
    thread.join()
    assert during.threads == before.threads + 1
    assert during.descriptors == before.descriptors + 1
    assert before.memory > 1000


def test_sampler_outlives_its_processes(monkeypatch: "pytest.MonkeyPatch") -> None:
    monkeypatch.setattr(Sampler, "PERIOD", 0.001)
    seen = threading.Event()
    with Sampler({"this": os.getpid(), "gone": 2**22 + 1}) as sampler:
        while not sampler.samples["this"]:
            seen.wait(0.001)
    assert isinstance(sampler.samples["this"][0], Usage)
    assert sampler.samples["gone"] == []


def test_size_of_counts_files_once(tmp_path: pathlib.Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "b").write_bytes(b"12345")
    (tmp_path / "link").symlink_to(tmp_path / "a" / "b")
    assert size_of(tmp_path) == 5
