"""ci/mutants --wiring draws changes of modules, and has the tests of their package judge them."""

import ast
import dataclasses
import os
import pathlib
import shutil
import signal
import sys
import threading
import time
from typing import List, Set

import pytest
from nodekit.testing import running

from ci.lint import code_rules
from ci.mutation import judging, wiring
from ci.mutation import pure_modules as mutants
from ci.mutation.changes import Source
from ci.mutation.draw import Mutant, drawn, mutants_of
from ci.mutation.judging import Judge
from ci.mutation.nearest import UnitTests
from ci.mutation.verdicts import Verdicts
from ci.tiers.steps import Step


def changes_in(body: str, head: str = "def f(self, a, b):") -> List[str]:
    """Return what becomes of the lines of a function's body."""
    text = f"{head}\n" + "".join(f"    {line}\n" for line in body.splitlines())
    source = Source(text)
    found = [(source.lines_of(change)[2], source.changed(change)) for change in source.changes()]
    for after, changed in found:
        ast.parse(changed)
        assert after in " ".join(changed.split())
    return [after for after, _ in found]


CONDITIONAL = [
    "c = {1 for d in a if b}",
    "c = {0 for d in () if b}",
    "c = {0 for d in a if (not (b))}",
]


@pytest.mark.parametrize(
    "body, expected",
    [
        ("self.stop()", ["pass"]),
        ("self._x = a", ["pass"]),
        ("a += b", ["pass"]),
        ("del a[b]", ["pass"]),
        ("raise OSError('no')", ["pass"]),
        ("if a:\n    return", ["if (not (a)):", "pass"]),
        ("if a == b: c = a", ["if a != b: c = a"]),
        ("c = (a) is (b)", ["c = (a) is not (b)"]),
        ("c = a < b", ["c = a >= b"]),
        ("c = a in b", ["c = a not in b"]),
        ("c = not a", ["c = bool(a)"]),
        ("c = a and b", ["c = a or b"]),
        ("c = a - b", ["c = a + b"]),
        ("c = [1, True]", ["c = [2, True]", "c = [1, False]"]),
        ("c = a if b else a", ["c = a if (not (b)) else a"]),
        ("for c in a:\n    break", ["for c in ():", "pass"]),
        ("c = {d for d in a}", ["c = {d for d in ()}"]),
        ("c = {0 for d in a if b}", CONDITIONAL),
        ("try:\n    c = a\nexcept OSError:\n    d = b", ["except ():"]),
        ("a.warn(\n    'ä',\n    b,\n)", ["pass"]),
        ("c = 'ä' + a, a + b", ["c = 'ä' + a, a - b"]),
        ("def g() -> None:\n    a()", ["pass"]),
    ],
)
def test_one_thing_is_changed_at_a_time(body: str, expected: List[str]) -> None:
    assert changes_in(body) == expected


@pytest.mark.parametrize(
    "body",
    [
        "'''Return 1 and not 2.'''",
        "c: Callable[[Literal[1]], None] = a",
        "c = f'{a + 1}'",
        "c = 0.5",
        "time.sleep(0.5)",
        "log.debug('%d', a + 1)",
        "raise NotImplementedError",
        "c = a\nreturn c",
    ],
)
def test_hints_texts_and_figures_with_a_point_stay(body: str) -> None:
    assert changes_in(body) == []


def test_what_is_logged_stays_but_that_it_is_logged_may_not() -> None:
    assert changes_in("rospy.loginfo('%d', a + 1)") == ["pass"]
    assert changes_in("rospy.logdebug('%d', a + 1)") == []


def test_nothing_is_changed_outside_of_functions_nor_in_what_people_read() -> None:
    assert changes_in("return a + b", "def __repr__(self):") == []
    assert changes_in("self._x = a", "def __init__(self):") == []
    assert not Source("LIMIT = 1 + 1\nif LIMIT:\n    print(LIMIT)\n").changes()


def test_a_change_is_shown_with_the_whole_of_its_lines() -> None:
    (mutant,) = mutants_of("p/a.py", "def f(a):\n    a(\n        2.0\n    )  # why\n")
    assert mutant.described() == "src/p/a.py:2: a( 2.0 ) # why → pass # why"
    assert mutant.text == "def f(a):\n    pass  # why\n"


def test_whatever_is_changed_a_module_remains_python() -> None:
    found = wiring.draw(["serial_link", "launch_files_demo"], 200, 1)
    assert len({mutant.key for mutant in found}) == 200
    for mutant in found:
        ast.parse(mutant.text)


def test_a_draw_hardly_depends_on_what_else_is_in_a_module() -> None:
    body = "".join(f"    f{number}()\n" for number in range(100))
    text = f"def f():\n{body}"

    def keys(text: str, seed: int) -> Set[str]:
        return {mutant.key for mutant in drawn(mutants_of("a.py", text), 20, seed)}

    assert len(keys(text, 1) & keys(f"def g():\n    x()\n\n\n{text}", 1)) >= 19
    assert keys(text, 1) != keys(text, 2)


def test_modules_of_wiring_are_those_that_are_not_pure() -> None:
    names = {str(path) for path in wiring.modules_of([])}
    assert "nodekit/src/nodekit/node/node.py" in names
    assert "topic_scope/src/topic_scope/web/server.py" in names
    others = ("/nodekit/transport/", "/nodekit/testing/", "/scripts/")
    assert not [path for path in names if any(other in path for other in others)]
    assert {path.parts[0] for path in wiring.modules_of(["nodekit"])} == {"nodekit"}


@pytest.mark.parametrize("name", ["nowhere", "lifecycle_msgs"])
def test_a_package_without_modules_is_refused_by_name(name: str) -> None:
    with pytest.raises(mutants.Unfit, match=name):
        wiring.modules_of(["nodekit", name])


def test_the_unit_tests_of_a_module_begin_with_those_that_import_it() -> None:
    place = code_rules.SOURCES / "topic_scope"
    found = UnitTests().of(place / "src" / "topic_scope" / "web" / "server.py")
    assert found[0] == place / "test" / "unit" / "test_server.py"
    assert place / "test" / "unit" / "test_ring.py" not in found


def test_unit_tests_of_what_is_not_installed_are_left_out(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    monkeypatch.setattr(shutil, "which", lambda _: None)
    names = [test.name for test in UnitTests().all_of("diff_drive_sim")]
    assert "test_robot.py" in names and "test_rviz.py" not in names


def mutant(name: str) -> Mutant:
    return Mutant("p/a.py", 3, name, "pass", f"{name} changed", name)


def test_a_run_goes_on_where_one_has_ended(tmp_path: pathlib.Path) -> None:
    asked = [mutant("one"), mutant("two"), mutant("three")]
    first = Verdicts(tmp_path, asked)
    first.add(asked[0], "p/unit: test_one: 1 != 2", [])
    first.add(asked[1], "", ["p/slow: 1 != 2"])
    text = (tmp_path / "report.txt").read_text("utf-8")
    assert text == (
        "left out, as it fails without a mutant: p/slow: 1 != 2\n"
        "survived: src/p/a.py:3: two → pass\n"
        "1 of 2 killed, 50.0 %; wanted are 90 %; 3 were drawn\n"
        "killed:\n"
        "src/p/a.py:3: one → pass\n"
        "    p/unit: test_one: 1 != 2\n"
    )
    second = Verdicts(tmp_path, asked)
    assert second.waiting() == [asked[2]] and second.share() == 50.0
    second.forget_survivors()
    assert second.waiting() == asked[1:] and second.share() == 100.0


MODULE = "p/src/p/a.py"
TEXT = "def f() -> int:\n    return 1\n"


@pytest.fixture
def copy(tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch") -> pathlib.Path:
    """A copy of a package without unit tests, which processes import from."""
    monkeypatch.setattr(mutants, "COPY", tmp_path / "copy")
    monkeypatch.setattr(UnitTests, "of", lambda *_: [])
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "copy" / "src" / "p" / "src"))
    for name in ("PYTHONPYCACHEPREFIX", running.FAIL_FAST):  # are set by what is tested
        monkeypatch.setenv(name, "")
    module = tmp_path / "copy" / "src" / MODULE
    module.parent.mkdir(parents=True)
    module.write_text(TEXT)
    return module


def offer(monkeypatch: "pytest.MonkeyPatch", **commands: str) -> None:
    """Have a package with these integration tests, each some Python."""
    steps = [
        Step("integration", f"p/{name}", [sys.executable, "-c", command])
        for name, command in commands.items()
    ]
    monkeypatch.setattr(judging, "integration_steps", lambda _: steps)


def test_a_mutant_is_met_by_the_tests_that_import_its_module_the_shortest_first(
    copy: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    offer(
        monkeypatch,
        long="import time; from p.a import f; time.sleep(4.0); assert f() < 3",
        short="from p.a import f; assert f() in (1, 3)",
        other="assert True",
        broken="from p.a import f; assert f() == 7",
    )
    judge = Judge(tmp_path)
    list(judge.tests_of(MODULE))  # which finds out how long they are
    assert [step.name for step in judge.tests_of(MODULE)] == ["p/short", "p/long"]
    (left_out,) = judge.left_out()
    assert left_out.startswith("p/broken: ") and "AssertionError" in left_out
    # Of one length, and within a second: what is compiled of the one is not taken for the other.
    killers = [judge.killer(MODULE, TEXT.replace("1", figure)) for figure in "2319"]
    assert [killer.split(":")[0] for killer in killers] == ["p/short", "p/long", "", "p/short"]
    assert copy.read_text() == TEXT
    judge.close()
    assert not (tmp_path / "compiled").exists()


def test_a_long_test_is_not_tried_where_a_short_one_kills(
    copy: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    offer(monkeypatch, long="assert False", short="from p.a import f; assert f() == 1")
    long, short = judging.integration_steps("p")
    steps = [long, dataclasses.replace(short, time_limit=long.time_limit / 2)]
    monkeypatch.setattr(judging, "integration_steps", lambda _: steps)
    judge = Judge(tmp_path)
    assert judge.killer(MODULE, TEXT.replace("1", "2")).startswith("p/short: ")
    assert not judge.left_out()
    judge.close()


def test_what_is_known_of_a_test_holds_until_it_changes(
    copy: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    seen, test = tmp_path / "seen", tmp_path / "test_it.py"
    test.write_text(f"import p.a; open({str(seen)!r}, 'a').write('x')")
    step = Step("integration", "p/it", [sys.executable, str(test)])
    monkeypatch.setattr(judging, "integration_steps", lambda _: [step])
    for expected in ("x", "x"):
        judge = Judge(tmp_path)
        assert len(list(judge.tests_of(MODULE))) == 1
        judge.close()
        assert seen.read_text() == expected
    good = test.read_text() + "\n"
    for text, expected in (
        (good, "xx"),
        (good + "assert 0", "xxxx"),
        (good + "assert 0", "xxxxxx"),
    ):
        test.write_text(text)
        judge = Judge(tmp_path)
        list(judge.tests_of(MODULE))
        judge.close()
        # One that fails is run twice, and again by the next judge.
        assert seen.read_text() == expected


def test_the_nearest_unit_tests_come_before_the_others(
    copy: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    files = [tmp_path / f"test_{number}.py" for number in range(judging.NEAREST + 2)]
    for file in files:
        file.write_text("def test_it(): pass\n")
    monkeypatch.setattr(UnitTests, "of", lambda *_: files)
    monkeypatch.setattr(UnitTests, "all_of", lambda *_: files)
    monkeypatch.setattr(judging, "integration_steps", lambda _: [])
    judge = Judge(tmp_path)
    first, second = judge.tests_of(MODULE)
    for step, run, left in ((first, files[:3], files[3:]), (second, files[3:], files[:3])):
        assert set(map(str, run)) <= set(step.command)
        assert not set(map(str, left)) & set(step.command)
    judge.close()


def test_a_rostest_ends_with_the_first_test_that_fails(
    copy: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    offer(monkeypatch, it=f"import os, p.a; assert os.environ[{running.FAIL_FAST!r}]")
    judge = Judge(tmp_path)
    assert list(judge.tests_of(MODULE)) and not judge.left_out()
    judge.close()


def test_a_mutant_that_runs_in_circles_is_killed_by_the_time(
    copy: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    monkeypatch.setattr(judging, "ON_TOP_S", 0.5)
    monkeypatch.setattr("ci.tiers.steps.GRACE", 0.1)
    offer(monkeypatch, it="from p.a import f; f()")
    judge = Judge(tmp_path)
    killer = judge.killer(MODULE, "def f():\n    while True:\n        pass\n")
    judge.close()
    assert "stopped: it took more than" in killer


def test_ctrl_c_ends_the_test_that_is_running_and_leaves_no_mutant(
    copy: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
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
    judge = Judge(tmp_path)
    list(judge.tests_of(MODULE))

    def interrupt() -> None:
        while not begun.exists():
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        judge.killer(MODULE, TEXT.replace("1", "2"))
    judge.close()
    assert ended.exists() and copy.read_text() == TEXT


def test_what_was_judged_up_to_ctrl_c_is_told(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    def judge(verdicts: Verdicts, minutes: float) -> None:
        verdicts.add(verdicts.waiting()[0], "", [])
        raise KeyboardInterrupt

    monkeypatch.setattr(wiring, "PLACE", tmp_path)
    monkeypatch.setattr(wiring, "judge", judge)
    monkeypatch.setattr(sys, "argv", ["wiring.py", "--only", "launch_files_demo", "--count", "5"])
    assert wiring.main(wiring.options()) == 130
    first, last = capsys.readouterr().out.splitlines()
    assert first.startswith("survived: src/launch_files_demo/")
    assert last == "0 of 1 killed, 0.0 %; wanted are 90 %; 5 were drawn"


def test_what_fails_by_the_way_kills_nothing(
    copy: pathlib.Path, tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    mark = tmp_path / "mark"
    offer(
        monkeypatch,
        it=f"import p.a, pathlib\nif not pathlib.Path({str(mark)!r}).exists():\n"
        f"    pathlib.Path({str(mark)!r}).touch(); assert False",
    )
    judge = Judge(tmp_path)
    assert list(judge.tests_of(MODULE)) and not judge.left_out()
    mark.unlink()
    assert judge.killer(MODULE, TEXT.replace("1", "2")) == ""
    judge.close()


def test_every_integration_test_is_told_from_what_it_was() -> None:
    """A .test may start a program that lies elsewhere, as judge.test does."""
    packages = [path.parts[0] for path in wiring.modules_of([])]
    steps = [step for name in sorted(set(packages)) for step in judging.integration_steps(name)]
    names = {step.name for step in steps}
    assert {"pid_control/judge", "nodekit/node", "ros2_bridge/test_life"} <= names
    assert len({judging.digest_of(step) for step in steps}) == len(steps)
