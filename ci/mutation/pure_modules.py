"""Change one thing of a module at a time, and see whether the nearest unit tests notice.

``mutants.py BIN [PATH…]``, with cosmic-ray's folder of commands: see ci/mutants.
"""

import json
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import time
from typing import Dict, List, NamedTuple, Sequence

from ..lint import code_rules

WORKSPACE = code_rules.SOURCES.parent
GENERATED = WORKSPACE / "devel" / "lib" / "python3" / "dist-packages"
COPY = WORKSPACE / "build" / "mutants"

#: The least share of mutants that must die, %.
GOAL = 90.0
#: How much longer than without a mutant the tests may take, and the least time they get, s.
LONGER, LEAST_S = 5.0, 10.0

#: What tests a module where that is not test_MODULE.py alone, by package and module.
TESTS: Dict[str, Sequence[str]] = {
    "nodekit/declaration": ("judging", "parameters", "schema", "parameter_kinds"),
    "nodekit/groups": ("groups", "ready_queue", "executors"),
    "nodekit/judging": ("judging", "reconciler"),
    "nodekit/kinds": ("parameter_kinds", "bytes_parameter", "schema"),
    "nodekit/ready_queue": ("ready_queue", "executors"),
    "nodekit/link": ("delivery",),
    "nodekit/machine": ("lifecycle",),
    "nodekit/number_kinds": ("parameter_kinds", "schema"),
    "nodekit/refusals": ("parameters", "reconciler"),
    "nodekit/lifecycle_states": ("lifecycle",),
    "first_order_sys_sim/first_order_plant": ("plant", "extremes"),
    "first_order_sys_sim/sampled_plant": ("plant", "extremes"),
    "motor_control/motor_parameters": ("parameters",),
    "diff_drive_sim/limits": ("robot",),
    "diff_drive_sim/world": ("robot", "laser"),
    "executors_demo/picture": ("timeline",),
    "executors_demo/timeline_command": ("timeline",),
    "robot_interfaces_demo/modes": ("problems", "robot_model"),
    "robot_interfaces_demo/problems": ("fleet", "problems"),
    "robot_interfaces_demo/robot": ("fleet",),
    "robot_interfaces_demo/settings": ("fleet", "problems"),
    "pid_control/class_page": ("judgement",),
    "pid_control/causes": ("judgement",),
    "pid_control/experiment": ("scenarios",),
    "pid_control/limits": ("judgement",),
    "pid_control/lines": ("measures",),
    "pid_control/picture": ("judgement",),
    "pid_control/record": ("measures", "judgement"),
    "pid_control/reports": ("judgement",),
    "lifecycle_manager/commands": ("system",),
    "lifecycle_manager/member": ("system",),
    "lifecycle_manager/plan": ("plan", "system"),
    "bot_controller_demo/freshness": ("pursuit",),
    "bot_controller_demo/geometry": ("pursuit",),
    "bot_controller_demo/steering": ("pursuit", "closed_loop"),
    "bot_controller_demo/keys": ("teleop_keys",),
    "bot_controller_demo/pursuit": ("pursuit", "closed_loop"),
    "bot_controller_demo/straight_line": ("closed_loop",),
    "bot_controller_demo/velocities": ("pursuit",),
    "pid_control/fit": ("identification",),
    "pid_control/reading": ("identification",),
    "pid_control/report": ("identification",),
    "ros2_bridge/instructions": ("codec",),
    "serial_link/cpp_class": ("make_headers",),
    "serial_link/frames": ("frames", "decoder"),
    "serial_link/wire_header": ("make_headers",),
    "basic_comms/conditioner": ("conditioning",),
    "basic_comms/multisine": ("waveforms", "signal_source"),
    "basic_comms/phase_estimate": ("phase_estimate", "phase_tracking"),
    "basic_comms/phase_intervals": ("phase_tracking",),
    "basic_comms/prbs": ("noise", "signal_source"),
    "basic_comms/shapes": ("signal_source", "delay_line"),
    "basic_comms/signal_parameters": ("signal_parameters", "signal_source"),
    "topic_scope/bag_lines": ("overlay", "plot_bag_command"),
    "topic_scope/bag_messages": ("bag_file",),
    "topic_scope/bag_series": ("bag_plot", "plot_bag_command"),
    "topic_scope/checks": ("requests", "scaling"),
    "topic_scope/crossings": ("periods", "known_signals"),
    "topic_scope/decoding": ("fields", "arrays"),
    "topic_scope/definitions": ("fields",),
    "topic_scope/derived": ("derived", "recorder"),
    "topic_scope/computed": ("requests",),
    "topic_scope/computed_csv": ("plot_bag_command",),
    "topic_scope/failure_file": ("mask",),
    "topic_scope/figure": ("known_signals", "measurements"),
    "topic_scope/laid": ("overlay",),
    "topic_scope/laying": ("requests",),
    "topic_scope/markers": ("scene",),
    "topic_scope/names": ("formulas",),
    "topic_scope/nodes": ("formulas", "differences"),
    "topic_scope/reading": ("formulas",),
    "topic_scope/signals": ("formula_signals", "formulas"),
    "topic_scope/steps": ("known_signals", "measurements"),
    "topic_scope/waves": ("known_signals", "measurements"),
    "topic_scope/words": ("formulas",),
    "topic_scope/periods": ("periods", "known_signals"),
    "topic_scope/message_source": ("recorder",),
    "topic_scope/computed_trace": ("recorder", "differences"),
    "topic_scope/traces": ("recorder", "differences"),
    "topic_scope/view": ("decimation",),
}

#: Of cosmic-ray's many ways to replace an operator those that differ least from it: tests that
#: notice a "-" in place of a "+" notice a "**" as well.
REPLACED = """
    Add_Sub Sub_Add Mul_Div Div_Mul FloorDiv_Div Mod_FloorDiv Pow_Mul LShift_RShift
    RShift_LShift BitOr_BitAnd BitAnd_BitOr BitXor_BitAnd Eq_NotEq NotEq_Eq Is_IsNot IsNot_Is
    Lt_LtE Lt_GtE LtE_Lt LtE_Gt Gt_GtE Gt_LtE GtE_Gt GtE_Lt Delete_USub Delete_Not Delete_Invert
""".split()
CONFIGURATION = """
[cosmic-ray]
module-path = {module}
test-command = {command}
timeout = {seconds}
excluded-modules = []
[cosmic-ray.distributor]
name = "local"
[cosmic-ray.filters.operators-filter]
exclude-operators = [{excluded}]
"""
#: The tests of a mutant need not find the simplest example that fails.
CONFTEST = """
from hypothesis import Phase, settings

phases = [Phase.explicit, Phase.generate]
settings.register_profile("once", derandomize=True, deadline=None, phases=phases)
settings.load_profile("once")
"""
#: A child that does not outlive us: a mutant may run in circles.
ENDS_WITH_US = ("setpriv", "--pdeathsig", "KILL")


class Tally(NamedTuple):
    """What became of a module's mutants."""

    made: int
    #: Those whose tests did not end in time; they count as killed.
    late: int
    survivors: List[str]

    def line(self, name: str) -> str:
        """Return the figures as a line of the table."""
        killed = self.made - len(self.survivors)
        late = f", {self.late} of them by the time limit" if self.late else ""
        return f"{name}: {killed} of {self.made} killed, {percent(killed, self.made):.1f} %{late}"


class Unfit(Exception):
    """A reason why there is nothing to measure."""


def percent(killed: int, made: int) -> float:
    return 100.0 * killed / made if made else 100.0


def modules_of(paths: Sequence[str]) -> List[pathlib.Path]:
    """Return the modules to change.

    :param paths: files and folders; all that is pure if there is none
    :raises Unfit: if a path has no module of a package
    """
    # What a room's __init__.py says of it is no code.
    known = {path: name for name, path in code_rules.modules() if path.name != "__init__.py"}
    if not paths:
        return [path for path, name in known.items() if code_rules.is_in(name, code_rules.PURE)]
    found: List[pathlib.Path] = []
    for text in paths:
        place = pathlib.Path(text).resolve()
        below = [path for path in known if place == path or place in path.parents]
        if not below:
            raise Unfit(f"{text} is not a module of a package, and contains none")
        found += [path for path in below if path not in found]
    return found


def tests_of(module: pathlib.Path) -> List[pathlib.Path]:
    """Return the files with the unit tests that are nearest to a module.

    :raises Unfit: if there is none, and none is known to be missing
    """
    package = code_rules.SOURCES / module.relative_to(code_rules.SOURCES).parts[0]
    subjects = TESTS.get(f"{package.name}/{module.stem}", (module.stem,))
    tests = [package / "test" / "unit" / f"test_{subject}.py" for subject in subjects]
    for test in tests:
        if not test.is_file():
            name = module.relative_to(WORKSPACE)
            raise Unfit(f"{name} has no {test.name}: name what tests it in {__name__}")
    return tests


def tally(dump: str) -> Tally:
    """Sum up what cosmic-ray has written of one module.

    :param dump: a line of JSON for each mutant: what was changed, and what came of it
    :raises Unfit: if a mutant was not tried
    """
    made, late, survivors = 0, 0, []
    for line in dump.splitlines():
        item, result = json.loads(line)
        if result and result["worker_outcome"] == "skipped":
            continue
        if not result or result["test_outcome"] not in ("killed", "survived"):
            raise Unfit(f"cosmic-ray could not try a mutant: {result and result['output']}")
        made += 1
        late += result["output"] == "timeout"
        if result["test_outcome"] == "survived":
            mutation = item["mutations"][0]
            where = f"{mutation['module_path']}:{mutation['start_pos'][0]}"
            survivors.append(f"{where}: {change(result['diff'])}")
    return Tally(made, late, sorted(survivors, key=lambda text: int(text.split(":")[1])))


def change(diff: str) -> str:
    """Return what a unified diff changes, in one line."""
    lines = [line for line in diff.splitlines() if not line.startswith(("---", "+++"))]
    return "  ".join(
        f"{sign} " + " ".join(line[1:].strip() for line in lines if line[:1] == sign)
        for sign in "-+"
        if any(line[:1] == sign for line in lines)
    )


def copy_sources() -> None:
    """Make the copy that is changed, with the generated modules among the written ones."""
    shutil.rmtree(str(COPY), ignore_errors=True)
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(str(code_rules.SOURCES), str(COPY / "src"), symlinks=True, ignore=ignored)
    for place in [*GENERATED.glob("*/msg"), *GENERATED.glob("*/srv")]:
        library = COPY / "src" / place.parent.name / "src" / place.parent.name
        if library.is_dir():
            shutil.copytree(str(place), str(library / place.name))
    shutil.copy(str(WORKSPACE / "pyproject.toml"), str(COPY))
    (COPY / "conftest.py").write_text(CONFTEST)
    places = [str(place) for place in (COPY / "src").glob("*/src")]
    os.environ["PYTHONPATH"] = os.pathsep.join(places + [os.environ["PYTHONPATH"]])


def run(*command: str) -> str:
    """Run a command in the copy, and return what it writes.

    :raises Unfit: if it fails
    """
    done = subprocess.run(
        [*ENDS_WITH_US, *command],
        cwd=str(COPY),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
    )
    if done.returncode:
        raise Unfit(f"'{shlex.join(command)}' failed:\n{done.stdout}")
    return done.stdout


def try_mutants(tool: pathlib.Path, module: pathlib.Path) -> Tally:
    """Make the mutants of a module, one after the other, and run the tests on each.

    :raises Unfit: if the tests fail without a mutant
    """
    tests = [str(test.relative_to(WORKSPACE)) for test in tests_of(module)]
    command = [sys.executable, "-B", "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *tests]
    began = time.monotonic()
    run(*command)
    seconds = max(LONGER * (time.monotonic() - began), LEAST_S)
    excluded = rf"core/Replace\w+Operator_(?!({'|'.join(REPLACED)})$)"
    text = CONFIGURATION.format(
        module=json.dumps(str(module.relative_to(WORKSPACE))),
        command=json.dumps(shlex.join([*ENDS_WITH_US, *command])),
        seconds=seconds,
        excluded=json.dumps(excluded),
    )
    (COPY / "configuration").write_text(text)
    (COPY / "session").unlink(missing_ok=True)
    run(str(tool / "cosmic-ray"), "init", "configuration", "session")
    run(str(tool / "cr-filter-operators"), "session", "configuration")
    run(str(tool / "cosmic-ray"), "exec", "configuration", "session")
    return tally(run(str(tool / "cosmic-ray"), "dump", "session"))


def main(tool: str, paths: Sequence[str]) -> int:
    """Try all, and print the survivors and the figures.

    :returns: exit status
    """
    killed = made = 0
    try:
        modules = modules_of(paths)
        for module in modules:
            tests_of(module)
        copy_sources()
        for module in modules:
            name = str(module.relative_to(WORKSPACE))
            found = try_mutants(pathlib.Path(tool), module)
            print("\n".join([*found.survivors, found.line(name)]))
            sys.stdout.flush()
            made += found.made
            killed += found.made - len(found.survivors)
    except Unfit as error:
        print(f"ci/mutants: {error}", file=sys.stderr)
        return 125
    except KeyboardInterrupt:
        return 130
    print(f"{killed} of {made} killed, {percent(killed, made):.1f} %; wanted are {GOAL:.0f} %")
    return 0 if percent(killed, made) >= GOAL else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
