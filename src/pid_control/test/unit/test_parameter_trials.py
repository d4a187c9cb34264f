"""Tests of the trials with other parameters, with a law in place of the student's nodes."""

import math
import os
import pathlib
import shutil
import types
from typing import Any, Callable, List, Mapping, Sequence, Tuple
from unittest import mock

import pytest

from pid_control.signal_judging.channels import Channel
from pid_control.signal_judging.evidence import (
    GENERATOR,
    PROCESS,
    BaselineTrial,
    ParameterEffect,
    ParameterResults,
    TrialFeatures,
)
from pid_control.signal_judging.features import SINE, ProcessFeatures, SignalFeatures
from pid_control.signal_judging.sine_fit import SineFit
from pid_control.signal_runner.coursework import Coursework, find_coursework
from pid_control.signal_runner.parameter_trials import ParameterTrials
from pid_control.signal_runner.node_pair import NodePair
from pid_control.signal_runner.trial import TrialError

COURSEWORKS = pathlib.Path(__file__).resolve().parents[1] / "courseworks"
NOTHING = Channel("/x", "", [], [])
Law = Callable[[Mapping[str, Any]], TrialFeatures]


def features(
    amplitude: float, omega: float, gain: float, angle: float, offset: float
) -> TrialFeatures:
    return TrialFeatures(
        SignalFeatures(10.0, SineFit(amplitude, omega, 0.0, 0.0, 0.0, 3.0)),
        ProcessFeatures(10.0, SINE, gain, (angle, angle), offset, 0.0, 0.0, 0),
    )


def wave_loops(parameters: Mapping[str, Any]) -> TrialFeatures:
    return features(
        parameters.get("/signal_amplitude", 1.0),
        parameters.get("/signal_omega", 1.0),
        parameters.get("/process_amplitude", 0.5),
        parameters.get("/process_angle", 1.5),
        parameters.get("/process_offset", 1.0),
    )


def tried(
    folder: pathlib.Path,
    law: Law,
    own: Mapping[str, Any] = types.MappingProxyType({}),
    words: Sequence[str] = (),
) -> Tuple[ParameterResults, ParameterTrials, List[Coursework]]:
    """Return the parameters of a coursework that follows a law, its trials, and the run ones."""
    coursework = find_coursework(str(folder), words, {"PATH": "/usr/bin:/bin"})
    process, generator = coursework.nodes
    ran: List[Coursework] = []

    def run(one: Coursework) -> TrialFeatures:
        ran.append(one)
        return law(one.parameters)

    pair = NodePair(generator, process, {}, {}, {})
    baseline = BaselineTrial(law(coursework.parameters), NOTHING, NOTHING, {}, own)
    trials = ParameterTrials(coursework, pair, baseline, run)
    return trials.run(), trials, ran


def copy(name: str, folder: pathlib.Path, file: str, old: str, new: str) -> pathlib.Path:
    package = folder / name
    shutil.copytree(str(COURSEWORKS / name), str(package))
    text = (package / file).read_text()
    assert old in text
    (package / file).write_text(text.replace(old, new))
    return package


def test_good_coursework_needs_one_trial_of_a_copy() -> None:
    found, trials, ran = tried(COURSEWORKS / "wave_loops", wave_loops)
    assert len(ran) == 1 and ran[0].folder != str(COURSEWORKS / "wave_loops")
    assert all(one.is_predicted for one in found.tried) and len(found.tried) == 5
    assert (found.read_by(GENERATOR), found.read_by(PROCESS)) == (2, 3)
    assert found.unread() == [] and dict(found.unused_files) == {} and found.has_files
    assert trials.notes == []
    assert found.value_of(PROCESS, "phase_shift") == ("/process_angle", 1.2)


def test_copy_is_launched_with_the_arguments_and_has_no_large_files(
    tmp_path: pathlib.Path, monkeypatch: "pytest.MonkeyPatch"
) -> None:
    package = copy(
        "wave_loops",
        tmp_path,
        "launch/cw1.launch",
        "config/params.yaml",
        "$(arg file).yaml",
    )
    launch = package / "launch" / "cw1.launch"
    text = launch.read_text().replace("<launch>", '<launch><arg name="file" default="no"/>')
    launch.write_text(text)
    for name in (".git/a", "run.bag", "config/note.txt"):
        (package / name).parent.mkdir(exist_ok=True)
        (package / name).write_text("")
    (package / "no.yaml").write_text("{}")
    words = ["cw1.launch", "file:=config/params"]
    copied: List[str] = []
    copytree = shutil.copytree

    def copy_all(*given: Any, **options: Any) -> str:
        folder = copytree(*given, **options)
        copied.extend(os.listdir(folder))
        return folder

    monkeypatch.setattr(shutil, "copytree", copy_all)
    found, trials, [one] = tried(package, wave_loops, words=words)
    assert "note.txt" in copied and not {".git", "run.bag"} & set(copied)
    assert all(effect.is_predicted for effect in found.tried) and len(found.tried) == 5
    assert (one.launch_file, one.arguments) == (f"{one.folder}/launch/cw1.launch", words[1:])
    assert pathlib.Path(one.folder).name == "wave_loops" and trials.notes == []
    assert not pathlib.Path(one.folder).exists()
    assert one.parameters == {
        "/signal_amplitude": 3.0,
        "/signal_omega": 3.75,
        "/process_angle": 1.6,
        "/process_offset": 2.0,
        "/process_amplitude": 0.7,
    }


def test_parameters_of_a_package_that_cannot_be_copied_are_tried(
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(shutil, "copytree", fail)
    found, trials, _ = tried(COURSEWORKS / "wave_loops", wave_loops)
    assert (found.read_by(GENERATOR), found.read_by(PROCESS)) == (2, 3)
    says = "YAML files: not changed, because the package cannot be copied (disk full)"
    assert trials.notes == [says] and dict(found.unused_files) == {}


def test_files_of_the_student_are_not_changed() -> None:
    file = COURSEWORKS / "wave_loops" / "config" / "params.yaml"
    before = file.read_text()
    tried(COURSEWORKS / "wave_loops", wave_loops)
    assert file.read_text() == before


def test_parameter_without_effect_is_tried_by_other_names() -> None:
    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        return wave_loops(
            {**parameters, "/signal_omega": parameters.get("/process/signal_omega", 3)}
        )

    found, trials, _ = tried(COURSEWORKS / "wave_loops", law)
    unread = ParameterEffect("/signal_omega", 3.0, "frequency", set(), ["/process/signal_omega"])
    assert found.unread() == [unread]
    assert trials.notes == []  # the verdict names it


def test_output_that_does_not_follow_other_numbers_is_noted() -> None:
    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        found = wave_loops(parameters)
        assert found.process is not None
        distortion = 0.0 if parameters["/signal_omega"] == 3 else 1.0
        return found._replace(process=found.process._replace(distortion=distortion))

    found, trials, _ = tried(COURSEWORKS / "wave_loops", law)
    assert found.unread() == []
    assert trials.notes == [
        "with other numbers the output is no longer a sine of the signal's frequency: one of: the"
        " process node has an amplitude or a frequency of its own, in its code or as a parameter,"
        " or the numbers do not fit together"
    ]


def test_output_that_is_distorted_with_any_numbers_is_not_blamed_on_them() -> None:
    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        found = wave_loops(parameters)
        assert found.process is not None
        return found._replace(process=found.process._replace(distortion=1.0))

    _, trials, _ = tried(COURSEWORKS / "wave_loops", law)
    assert trials.notes == []


def test_more_numbers_than_can_be_tried_are_named(tmp_path: pathlib.Path) -> None:
    more = "".join(f"number_{letter}: 1\n" for letter in "abcdefghij")
    package = copy(
        "wave_loops", tmp_path, "config/params.yaml", "signal_omega", f"{more}signal_omega"
    )
    found, trials, ran = tried(package, wave_loops)
    assert trials.notes == ["parameters not tried: /number_i, /number_j"]
    assert found.hidden == set() and len(ran) == 1 + 2 * 8
    assert {one.name for one in found.unread()} == {f"/number_{letter}" for letter in "abcdefgh"}


def test_of_two_numbers_with_one_role_each_is_tried(tmp_path: pathlib.Path) -> None:
    package = copy(
        "wave_loops",
        tmp_path,
        "config/params.yaml",
        "signal_omega",
        "signal_amplitude_b: 2.0\nsignal_omega",
    )
    found, _, _ = tried(package, wave_loops)
    of = {one.name: set(one.of) for one in found.tried}
    assert (of["/signal_amplitude_b"], of["/signal_amplitude"]) == (set(), {GENERATOR})
    assert found.value_of(GENERATOR, "amplitude") == ("/signal_amplitude", 2.0)


def test_name_in_capitals_belongs_to_its_node(tmp_path: pathlib.Path) -> None:
    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        return wave_loops({**parameters, "/signal_amplitude": parameters["/SIGNAL_AMPLITUDE"]})

    package = copy(
        "wave_loops", tmp_path, "config/params.yaml", "signal_amplitude", "SIGNAL_AMPLITUDE"
    )
    found, _, _ = tried(package, law)
    assert found.value_of(GENERATOR, "amplitude") == ("/SIGNAL_AMPLITUDE", 2.0)


def test_files_that_are_no_yaml_or_lead_nowhere_are_left_alone(tmp_path: pathlib.Path) -> None:
    package = copy("wave_loops", tmp_path, "package.xml", "", "")
    (package / "config" / "a_draft.yaml").write_text("[")
    (package / "dead_link").symlink_to("nowhere")
    found, trials, _ = tried(package, wave_loops)
    assert (found.read_by(GENERATOR), found.read_by(PROCESS)) == (2, 3)
    assert found.has_files and trials.notes == []


def test_parameter_that_ends_a_node_is_read() -> None:
    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        if parameters["/process_offset"] != 1.5:
            raise TrialError("ended", "/process")
        return wave_loops(parameters)

    found, _, ran = tried(COURSEWORKS / "wave_loops", law)
    assert len(ran) == 6  # all together, which failed, then one by one
    assert found.unread() == [] and found.hidden == set()
    coursework = find_coursework(str(COURSEWORKS / "wave_loops"), [], {"PATH": "/usr/bin:/bin"})
    own = dict(coursework.parameters)
    assert [one.parameters for one in ran[1:]] == [
        {**own, "/process_amplitude": 0.5 * 1.4 * 1.4},
        {**own, "/process_angle": 1.2 + 20.0},
        {**own, "/process_offset": 2.0},
        {**own, "/signal_amplitude": 4.5},
        {**own, "/signal_omega": 3.0 * 1.25 * 1.25},
    ]
    gain, angle, offset, amplitude, omega = found.tried
    assert gain == ("/process_amplitude", 0.5, "gain", {PROCESS}, [], True, True)
    assert angle == ("/process_angle", 1.2, "phase_shift", {PROCESS}, [], True, True)
    both = {GENERATOR, PROCESS}
    assert offset == ("/process_offset", 1.5, "offset", both, [], True, False)
    assert amplitude == ("/signal_amplitude", 2.0, "amplitude", {GENERATOR}, [], True, True)
    assert omega == ("/signal_omega", 3.0, "frequency", {GENERATOR}, [], True, True)


def test_unused_parameters_that_may_matter_elsewhere_are_noted(tmp_path: pathlib.Path) -> None:
    names = "process_offset_b: 1\nlog_every: 2\nother: 3\n"
    package = copy(
        "wave_loops", tmp_path, "config/params.yaml", "signal_omega", f"{names}signal_omega"
    )
    (package / "scripts" / "process.py").open("a").write("# process_offset_b, log_every\n")
    found, trials, ran = tried(package, wave_loops)
    assert trials.notes == ["parameters without effect here: /log_every, /process_offset_b"]
    [unread] = found.unread()
    assert unread == ParameterEffect("/other", 3.0, "", set(), [], False, False)
    # Those that a source mentions are tried under each name that a program may read.
    more = {name for one in ran for name in one.parameters} - set(ran[1].parameters)
    assert more == {
        f"/{node}/{last}"
        for node in ("process", "signal_generator")
        for last in ("log_every", "process_offset_b")
    }


def test_phase_in_degrees_that_is_far_is_seen(tmp_path: pathlib.Path) -> None:
    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        degrees = math.radians(parameters["/process_angle"])
        return wave_loops({**parameters, "/process_angle": degrees})

    package = copy("wave_loops", tmp_path, "config/params.yaml", "angle: 1.2", "angle: 60")
    found, _, _ = tried(package, law)
    assert found.value_of(PROCESS, "phase_shift") == ("/process_angle", 60.0)


def test_parameter_that_a_node_rejects_if_it_is_far_is_read() -> None:
    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        omega = parameters["/signal_omega"]
        return wave_loops({**parameters, "/signal_omega": omega**2 if omega < 4.0 else 9.0})

    found, _, _ = tried(COURSEWORKS / "wave_loops", law)
    assert found.unread() == []


def test_file_that_no_launch_file_loads_is_unused(tmp_path: pathlib.Path) -> None:
    package = copy("wave_loops", tmp_path, "launch/cw1.launch", "config/params.yaml", "x.yaml")
    (package / "x.yaml").write_text("{}")
    found, _, _ = tried(package, wave_loops)
    assert dict(found.unused_files) == {"params.yaml": "no launch file loads it"}
    assert found.hidden == {GENERATOR, PROCESS}  # by their names in the sources
    assert found.read_by(GENERATOR) == 1


def test_parameters_that_a_node_sets_itself_are_hidden_from_the_launch_file(
    tmp_path: pathlib.Path,
) -> None:
    """A node of nodekit declares its parameters without get_param, and sets their defaults."""

    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        return features(1.0, 1.0, parameters.get("/process/scale", 0.5), 1.5, 1.0)

    line = '<rosparam file="$(find wave_loops)/config/params.yaml" command="load"/>'
    package = copy("wave_loops", tmp_path, "launch/cw1.launch", line, "")
    (package / "config" / "params.yaml").unlink()
    own = {"/process/scale": 0.5, "/process/text": "a", "/process/on": True, "/processes/x": 1.0}
    found, _, ran = tried(package, law, own)
    assert (found.tried, found.hidden) == ([], {PROCESS})
    changed = [{name: one.parameters.get(name) for name in own} for one in ran]
    assert changed[-1] == {**dict.fromkeys(own), "/process/scale": 0.7}
    assert tried(package, law)[0].hidden == set()


@pytest.mark.parametrize("name", ["/rectifier/gain", "/gain"])
def test_private_name_in_a_source_is_hidden_from_a_launch_file_without_it(
    name: str, tmp_path: pathlib.Path
) -> None:
    line = '<rosparam command="load" file="$(find magnitude_vectors)/config/rectifier.yaml"/>'
    package = copy("magnitude_vectors", tmp_path, "launch/all.launch", line, "")
    (package / "config" / "rectifier.yaml").unlink()

    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        return features(3.0, 2.0, parameters.get(name, 0.7), 1.0, 1.0)

    assert tried(package, law)[0].hidden == ({PROCESS} if name == "/rectifier/gain" else set())


@pytest.mark.parametrize(
    ("numbers", "is_unused"),
    [
        ("signal_omega: 3", True),
        ("lab: {signal_amplitude: 2, signal_omega: 3}", True),
        ("process_offset: 2", False),  # an older version of the loaded file
        ("motor_gain: 2", False),  # of another activity: no source needs it
        ("rate: 10", False),  # a word in most sources, but no parameter of a node
    ],
)
def test_file_beside_a_loaded_one_is_unused_if_it_is_needed(
    numbers: str, is_unused: bool, tmp_path: pathlib.Path
) -> None:
    package = copy("wave_loops", tmp_path, "config/params.yaml", "signal_", "other_")
    (package / "config" / "generator.yaml").write_text(numbers)
    found, _, _ = tried(package, wave_loops)
    wanted = {"generator.yaml": "no launch file loads it"} if is_unused else {}
    assert dict(found.unused_files) == wanted


def test_file_of_another_activity_is_not_blamed_without_a_loaded_one(
    tmp_path: pathlib.Path,
) -> None:
    package = copy("sine_classes", tmp_path, "package.xml", "", "")
    (package / "motor.yaml").write_text("motor_gain: 2")
    found, _, _ = tried(package, lambda _: features(1.0, 1.0, 0.5, 1.0, 1.0))
    assert dict(found.unused_files) == {}


def test_file_with_overridden_numbers_is_unused(tmp_path: pathlib.Path) -> None:
    names = {"signal_amplitude": 2, "signal_omega": 3, "process_angle": 1}
    names.update({"process_offset": 1, "process_amplitude": 1})
    overriding = "".join(f'<param name="{one}" value="{names[one]}.5"/>' for one in names)
    package = copy(
        "wave_loops", tmp_path, "launch/cw1.launch", "</launch>", overriding + "</launch>"
    )
    found, _, _ = tried(package, wave_loops)
    assert dict(found.unused_files) == {"params.yaml": "cw1.launch loads it, but sets other values"}


def test_file_of_another_launch_file_or_of_a_program_is_noted(tmp_path: pathlib.Path) -> None:
    package = copy("wave_loops", tmp_path, "launch/cw1.launch", "config/params.yaml", "x.yaml")
    (package / "x.yaml").write_text("{}")
    (package / "launch" / "other.launch").write_text("<launch><!-- params.yaml --></launch>")
    (package / "own.yaml").write_text("a: 1")
    (package / "scripts" / "process.py").open("a").write("# open('own.yaml')\n")
    found, trials, _ = tried(package, wave_loops)
    assert dict(found.unused_files) == {}
    assert trials.notes == [
        "params.yaml is loaded by other.launch, not by cw1.launch",
        "own.yaml: the programs load it by themselves",
    ]
    (package / "launch" / "more.launch").write_text("<launch><!-- params.yaml --></launch>")
    notes = tried(package, wave_loops)[1].notes
    assert "params.yaml is loaded by more.launch, other.launch, not by cw1.launch" in notes


def test_text_or_list_of_numbers_is_a_parameter(tmp_path: pathlib.Path) -> None:
    def law(parameters: Mapping[str, Any]) -> TrialFeatures:
        amplitude, omega = parameters["/wave"]
        return features(amplitude, omega, 0.5, 1.0, float(parameters["/lift"]))

    package = copy("wave_loops", tmp_path, "config/params.yaml", "", "")
    (package / "config" / "params.yaml").write_text("wave: [2.0, 3.0]\nlift: '1.5'\nlog: name")
    found, _, ran = tried(package, law)
    assert (found.read_by(GENERATOR), found.read_by(PROCESS)) == (1, 1)
    own = {"/wave": [2.0, 3.0], "/lift": "1.5", "/log": "name"}
    others = [{name: one.parameters[name] for name in own} for one in ran]
    assert {**own, "/wave": [2.5, 3.75], "/lift": "1.875"} in others


def test_parameters_belong_to_the_node_of_their_place_or_name() -> None:
    coursework = find_coursework(str(COURSEWORKS / "sine_classes"), [], {"PATH": "/usr/bin:/bin"})
    process, generator = coursework.nodes
    baseline = BaselineTrial(wave_loops({}), NOTHING, NOTHING, {})
    pair = NodePair(generator, process, {}, {}, {})
    trials = ParameterTrials(coursework, pair, baseline, mock.Mock())
    assert {name: trials._role(name) for name in ROLES} == ROLES
    assert trials._names_of("gain") == [
        "/gain",
        "/lab/gain",
        "/lab/processor/gain",
        "/lab/source/gain",
    ]
    assert trials._places(PROCESS, "~a/b") == ["/lab/processor/a/b"]
    assert trials._places(GENERATOR, "~a") == ["/lab/source/a"]
    assert trials._places(GENERATOR, "a") == ["/lab/a"]
    assert trials._places(GENERATOR, "/a") == ["/a"]


#: Node and role of parameters by their names, of the nodes /lab/processor and /lab/source.
ROLES = {
    "/lab/processor/amplitude": (PROCESS, "gain"),
    "/lab/processor/signal_frequency": (PROCESS, ""),
    "/lab/source/proc_amplitude": (GENERATOR, "amplitude"),
    "/lab/source/phase_shift": (GENERATOR, "phase"),
    "/lab/sources/amplitude": ("", ""),
    "/a/proc_signal_gain": (PROCESS, "gain"),
    "/proc/Gen_rate": (GENERATOR, "rate"),
    "/SIN_offset": (GENERATOR, "offset"),
    "/signal": (GENERATOR, ""),
    "/a/omega": (GENERATOR, "frequency"),
    "/loop_frequency": ("", ""),
    "/freq_shift": (GENERATOR, "frequency"),
    "/angle": (PROCESS, "phase_shift"),
    "/gain": ("", ""),
    "/offset": ("", ""),
}


def test_coursework_without_parameters() -> None:
    found, _, ran = tried(COURSEWORKS / "sine_classes", lambda _: features(1.0, 1.0, 0.5, 1.0, 1.0))
    assert found.read_by(GENERATOR) == found.read_by(PROCESS) == 0
    assert not found.has_files and dict(found.unused_files) == {}
    assert len(ran) > 1


def test_value_of_two_parameters_of_a_role_is_unknown() -> None:
    one = ParameterEffect("/a", 2.0, "amplitude", {GENERATOR}, is_predicted=True)
    for tried, value in (([one], ("/a", 2.0)), ([one, one._replace(name="/b")], None)):
        assert ParameterResults(tried, set(), {}, True).value_of(GENERATOR, "amplitude") == value
