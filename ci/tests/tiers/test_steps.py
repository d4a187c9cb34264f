"""Tests of steps: results, and leftover processes."""

import contextlib
import os
import pathlib
import signal
import subprocess
import sys
import threading

import pytest

from ci.tiers import command, tier_plan, workspace
from ci.tiers.steps import Case, Runner, Step, StepResult, repeat_command
from ci.tiers.times import Times

PASSED = "<testcase name='a'/>"
FAILED = "<testcase name='b'><failure>\n1 is not 2\nat line 3</failure></testcase>"
BROKEN = "<testcase name='c'><error message='no such file'/></testcase>"
SKIPPED = "<testcase name='d'><skipped/></testcase>"


def run(directory: pathlib.Path, *command: str, **options: float) -> StepResult:
    step = Step("tier", "step", list(command), **options)  # type: ignore[arg-type]
    return Runner().run(step, directory / "step")


def run_writing(directory: pathlib.Path, status: int = 0, **files: str) -> StepResult:
    """Run a step that writes JUnit files, named with _ for -."""
    script = "; ".join(
        'echo "<testsuite>%s</testsuite>" > {results}/%s.xml' % (cases, name.replace("_", "-"))
        for name, cases in files.items()
    )
    return run(directory, "sh", "-c", f"{script or ':'}; exit {status}", writes_junit=True)


def tally(result: StepResult) -> tuple:
    return result.passed, result.failed, result.skipped, result.good


def test_a_plain_command_is_one_test(tmp_path: pathlib.Path) -> None:
    assert tally(run(tmp_path / "good", "true")) == (1, 0, 0, True)
    bad = run(tmp_path / "bad", "sh", "-c", "echo the reason >&2; exit 3")
    assert tally(bad) == (0, 1, 0, False)
    assert "the reason" in bad.log and "status 3" in bad.log


def test_cases_are_counted_by_their_end(tmp_path: pathlib.Path) -> None:
    result = run_writing(tmp_path, one=PASSED + PASSED + SKIPPED, two=FAILED + BROKEN + PASSED)
    assert tally(result) == (3, 2, 1, False)
    reasons = {case.name: case.reason for case in result.cases if case.outcome == "failed"}
    assert reasons == {"b": "1 is not 2 at line 3", "c": "no such file"}


def test_a_skipped_case_is_not_good(tmp_path: pathlib.Path) -> None:
    assert tally(run_writing(tmp_path, one=PASSED + SKIPPED)) == (1, 0, 1, False)


@pytest.mark.parametrize("files", [{}, {"empty": ""}])
def test_no_case_is_a_failure(tmp_path: pathlib.Path, files: dict) -> None:
    result = run_writing(tmp_path, **files)
    assert tally(result) == (0, 1, 0, False)
    assert "no test ran" in result.log


def test_a_bad_end_is_a_failure_though_all_cases_passed(tmp_path: pathlib.Path) -> None:
    assert tally(run_writing(tmp_path, status=2, one=PASSED)) == (1, 1, 0, False)


def test_half_a_file_is_a_failure(tmp_path: pathlib.Path) -> None:
    command = "echo '<testsuite>' > {results}/half.xml"
    assert tally(run(tmp_path, "sh", "-c", command, writes_junit=True)) == (0, 1, 0, False)


def test_rostests_own_file_counts_only_for_nodes_that_did_not_report(
    tmp_path: pathlib.Path,
) -> None:
    result = run_writing(tmp_path, rosunit_one=PASSED, rostest_file=PASSED + FAILED)
    assert tally(result) == (1, 1, 0, False)
    # A test node without tests.
    assert not run_writing(tmp_path / "none", rosunit_one="", rostest_file=PASSED).good


def test_time_limit_ends_escaped_processes_too(tmp_path: pathlib.Path) -> None:
    command = "setsid sleep 300 & echo $!; exec sleep 300"
    for limit in (4.0, 40.0):  # a busy machine may take long to start a shell
        result = run(tmp_path / str(limit), "sh", "-c", command, time_limit=limit)
        assert tally(result) == (0, 1, 0, False)
        assert "more than" in result.log
        if result.log.split()[0].isdigit():
            break
    escaped = int(result.log.split()[0])
    with pytest.raises(ProcessLookupError):
        wait_until_gone(escaped)


def wait_until_gone(pid: int) -> None:
    """Raise ProcessLookupError once a process has ended; return after a timeout."""
    for _ in range(6000):
        os.kill(pid, 0)
        # It may be reaped between the two calls, or stay a zombie that this process cannot reap.
        with contextlib.suppress(FileNotFoundError), open(f"/proc/{pid}/stat") as stat:
            if stat.read().split()[2] == "Z":
                raise ProcessLookupError(pid)
        threading.Event().wait(0.01)


def test_processor_time_is_that_of_all_it_started(tmp_path: pathlib.Path) -> None:
    burn = "import time\nwhile time.process_time() < 0.5: pass"
    inner = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {burn!r}])"
    assert run(tmp_path, sys.executable, "-c", inner).cpu_seconds >= 0.5


def test_steps_do_not_share_a_master_or_a_home(tmp_path: pathlib.Path) -> None:
    names = ("ROS_MASTER_URI", "ROS_HOME", "ROS_LOG_DIR", "TMPDIR", "HYPOTHESIS_STORAGE_DIRECTORY")
    command = ("sh", "-c", "echo " + " ".join("$" + name for name in names))
    one, other = (run(tmp_path / name, *command).log.split() for name in ("one", "other"))
    assert len(one) == len(other) == len(names)
    assert not set(one) & set(other)
    assert all(str(tmp_path) in path for path in one[1:])


def test_hangup_ends_processes_of_a_step_though_the_run_ignores_it(tmp_path: pathlib.Path) -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        result = run(tmp_path, "sh", "-c", "sh -c 'kill -HUP $$; echo ignored'; echo ended")
    finally:
        signal.signal(signal.SIGHUP, before)
    assert [line for line in result.log.splitlines() if line in ("ignored", "ended")] == ["ended"]


def result_of(name: str, cpu: float, **outcomes: int) -> StepResult:
    cases = [Case(str(n), outcome) for outcome, count in outcomes.items() for n in range(count)]
    return StepResult(Step("unit", name, []), cases, seconds=1.0, cpu_seconds=cpu, log="")


def test_closing_line_and_status(capsys: "pytest.CaptureFixture[str]") -> None:
    times = Times(pathlib.Path("/nowhere"))
    good = result_of("a", 90.0, passed=3)
    assert command.summarise([good, good], 2.0, times)
    assert capsys.readouterr().out.splitlines()[-1] == "6 passed, 0 failed, 0 skipped"

    bad = result_of("b", 150.0, passed=1, skipped=1)
    assert not command.summarise([good, bad], 2.0, times)
    told = capsys.readouterr().out.splitlines()
    assert told[-1] == "4 passed, 0 failed, 1 skipped"
    dearest = ["   150.0 s  unit/b", "    90.0 s  unit/a"]
    assert told[told.index("most of the processor time:") + 1 :][:2] == dearest
    assert "4.0 minutes of processor time" in told[-3]

    not_run = result_of("c", 0.0)
    assert not command.summarise([good, not_run], 2.0, times)
    assert capsys.readouterr().out.splitlines()[-1] == "3 passed, 1 failed, 0 skipped"


def test_summary_names_failed_tests_again_at_the_end(
    capsys: "pytest.CaptureFixture[str]",
) -> None:
    times = Times(pathlib.Path("/nowhere"))
    good, bad = result_of("a", 1.0, passed=1), result_of("b", 1.0, passed=1, failed=1)
    assert not command.summarise([good, bad], 2.0, times)
    told = capsys.readouterr().out.splitlines()
    assert told[told.index("FAILED unit/b") + 1 :][:2] == [
        "  failed: 0",
        "    again: ./ci/test unit",
    ]
    assert not any("FAILED unit/a" in line for line in told)


def test_a_step_that_has_grown_is_named(
    tmp_path: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    times = Times(tmp_path / "times.json")
    for _ in range(3):
        times.add("unit/a", 1.0, 10.0)
        times.add("unit/b", 1.0, 0.5)
    times.save()
    times = Times(tmp_path / "times.json")
    command.summarise([result_of("a", 16.0, passed=1), result_of("b", 1.5, passed=1)], 2.0, times)
    told = capsys.readouterr().out.splitlines()
    assert [line for line in told if "usually" in line] == ["unit/a: 16.0 s, usually 10.0 s"]


def test_rounds_name_the_failures_of_each(capsys: "pytest.CaptureFixture[str]") -> None:
    good, bad = result_of("a", 1.0, passed=2), result_of("a", 1.0, passed=1, failed=1)
    assert command.summarise_rounds([[good], [good]])
    assert capsys.readouterr().out.splitlines()[-1] == "2 passed, 0 failed, 0 skipped"
    once = StepResult(bad.step, [Case("0", "passed"), Case("1", "failed")], 1.0, 1.0, "")
    assert not command.summarise_rounds([[good], [once], [good]])
    told = capsys.readouterr().out.splitlines()
    assert told[0] == "2 of 3: unit/a: .1"
    assert told[-1] == "1 passed, 1 failed, 0 skipped"


def test_a_failure_names_the_command_that_repeats_it() -> None:
    step = tier_plan.pytest_step("ci", "tiers", pathlib.Path(__file__).parent)
    case = Case("test_a", "failed", "", "ci.tests.tiers.test_steps.TestB", "pytest")
    assert repeat_command(step, case) == "./ci/test ci/tests/tiers/test_steps.py::test_a"
    # A step that was ended at its time limit has written no cases.
    assert repeat_command(step, Case("tiers", "failed")) == "./ci/test ci"
    (process, *_) = tier_plan.SOURCES.glob("basic_comms/test/integration/process.test")
    step = tier_plan.rostest_step("integration", "basic_comms", [process])
    case = Case("test_a", "failed", "", "test_process.ProcessNode", "process")
    again = "./ci/test src/basic_comms/test/integration/process.test::test_a"
    assert repeat_command(step, case) == again
    assert repeat_command(Step("lint", "style", []), Case("style", "failed")) == "./ci/test lint"


def test_step_runs_after_its_prerequisite(
    tmp_path: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    made, seen = tmp_path / "made", tmp_path / "seen"
    steps = [
        Step("unit", "user", ["test", "-e", str(made)], after="maker"),
        Step(
            "unit",
            "maker",
            ["sh", "-c", f"until test -e '{seen}'; do sleep 0.05; done; touch '{made}'"],
        ),
        Step("unit", "other", ["sh", "-c", f"! test -e '{made}' && touch '{seen}'"]),
        Step("unit", "broken", ["false"]),
        Step("unit", "lost", ["touch", str(tmp_path / "lost")], after="broken"),
    ]
    code = (
        "import pathlib, sys; from ci.tiers import command, tier_plan, times;"
        "from ci.tiers.steps import Step;"
        f"times.FILE = pathlib.Path({str(tmp_path / 'times')!r});"
        f"tier_plan.plan = lambda *_: {steps!r}; sys.exit(command.main(['unit']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=dict(os.environ, PYTHONPATH=str(tier_plan.WORKSPACE), TMPDIR=str(tmp_path)),
        stdout=subprocess.PIPE,
        encoding="utf-8",
    )
    assert done.returncode == 1
    assert done.stdout.splitlines()[-1] == "3 passed, 2 failed, 0 skipped"
    assert "    not run: broken has failed" in done.stdout.splitlines()
    assert not (tmp_path / "lost").exists()


def test_step_that_has_just_ended_keeps_no_other_from_being_interrupted() -> None:
    runner = Runner()
    with subprocess.Popen(["true"], start_new_session=True) as gone:
        gone.wait()
    with subprocess.Popen(["sleep", "60"], start_new_session=True) as running:
        runner._running = [gone, running, gone]  # type: ignore[assignment]
        runner.interrupt()
        assert running.wait(30) != 0


def test_interrupt_leaves_no_process(tmp_path: pathlib.Path) -> None:
    command = ["sh", "-c", f"echo $$ > '{tmp_path / 'pid'}'; exec sleep 300"]
    code = (
        "import pathlib, sys; from ci.tiers import command, tier_plan, times;"
        "from ci.tiers.steps import Step;"
        "tier_plan.plan = lambda *_: [Step('unit', 'x', %r)] * 9; sys.exit(command.main(['unit']))"
    )
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    process = subprocess.Popen(
        [sys.executable, "-c", code % command],
        env=dict(os.environ, PYTHONPATH=str(tier_plan.WORKSPACE), TMPDIR=str(scratch)),
    )
    while not (tmp_path / "pid").exists() and process.poll() is None:
        threading.Event().wait(0.01)
    process.terminate()
    assert process.wait(60) == 130
    assert list(scratch.iterdir()) == []


def test_lint_looks_at_every_python_file_that_is_not_generated(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    own = ["ci/lint/one.py", "docs/_ext/two.py", "docs/conf.py", "src/three/scripts/three"]
    generated = ["docs/_build/html/four.py", "src/three/.hypothesis/five.py"]
    for name in [*own, *generated, "src/three/LICENSE"]:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("" if name.endswith("LICENSE") else "#!/usr/bin/env python3\n")
    for module in (tier_plan, workspace):
        monkeypatch.setattr(module, "WORKSPACE", tmp_path)
    places = [tmp_path / place for place in ("ci", "docs", "src")]
    assert tier_plan.python_files(*places) == [str(tmp_path / name) for name in own]


def test_list_of_a_selection_has_its_steps_alone(capsys: "pytest.CaptureFixture[str]") -> None:
    """A user who asks what would run does not want a list of everything."""
    assert command.main(["nodekit_msgs", "lint", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any("lint" in line for line in lines)
    assert lines[-1].endswith("steps. A dash: not run here yet.") and len(lines) < 20
    assert not any("topic_scope" in line for line in lines)
    assert command.main(["no_such_package", "--list"]) == 125
