"""Tests of the command identify, with bags and without a master."""

import pathlib
import sys
from typing import List, Tuple
from unittest import mock

import numpy
import pytest
import rosbag
import rospy
from std_msgs.msg import String

from pid_control.commands import identify as identify_command
from pid_control.identification.fit import identify as identify_plant
from pid_control.identification.model_file import as_yaml
from pid_control.identification.report import as_picture, as_text
from pid_control.identification.response import Model
from pid_control.identification.step_reading import read_step
from pid_control.msg import motor_input, motor_output
from pid_control.recording.bag_record import read_record
from pid_control.recording.fields import FieldError
from pid_control.recording.live_experiment import DriveError
from plants import answered


def identify(capsys: "pytest.CaptureFixture[str]", *arguments: str) -> Tuple[int, str, str]:
    """Run the command in this process; return the exit status, the output and the errors."""
    status = 0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["identify", *arguments])
        try:
            identify_command.main()
        except SystemExit as end:
            status = int(end.code or 0)
    output, errors = capsys.readouterr()
    return status, output, errors


@pytest.mark.parametrize(
    "arguments, why",
    [
        (["{folder}/none.bag"], "{folder}/none.bag: No such file or directory"),
        (["{folder}"], "{folder}: Is a directory"),
        (["--largest", "0"], "--least must be at most 0, and --largest above it"),
        (["--least", "0.1"], "--least must be at most 0, and --largest above it"),
        (["--least", "nan"], "error: argument --least: 'nan' is not a finite number"),
        (["--least", "low"], "error: argument --least: 'low' is not a finite number"),
        (["--largest", "inf"], "error: argument --largest: 'inf' is not a finite number"),
        (["--seconds", "0.99"], "error: argument --seconds: '0.99' must be from 1 to 3600 s"),
        (["--seconds", "3601"], "error: argument --seconds: '3601' must be from 1 to 3600 s"),
        (["--model", "{folder}/no/m.yaml"], "{folder}/no/m.yaml: No such file or directory"),
        (["--picture", "{folder}/no/p.svg"], "{folder}/no/p.svg: No such file or directory"),
        (["--start", "1"], "--start: only valid with a bag"),
        (["--end", "2"], "--end: only valid with a bag"),
        (["{folder}/none.bag", "--seconds", "5"], "--seconds: only valid without a bag"),
        (["{folder}/none.bag", "--least", "-1"], "--least: only valid without a bag"),
        (["{folder}/none.bag", "--largest", "2"], "--largest: only valid without a bag"),
        (["--model", "m.txt"], "error: argument --model: 'm.txt' does not end in .yaml or .yml"),
        (["--picture", "p.png"], "error: argument --picture: 'p.png' does not end in .svg"),
    ],
)
def test_identify_invalid_argument_names_the_problem(
    arguments: List[str],
    why: str,
    tmp_path: pathlib.Path,
    capsys: "pytest.CaptureFixture[str]",
    monkeypatch: "pytest.MonkeyPatch",
) -> None:
    # Nothing is driven for a file that could not be written.
    monkeypatch.setattr(identify_command, "run", lambda *_: pytest.fail("a plant was driven"))
    words = [word.format(folder=tmp_path) for word in arguments]
    status, output, errors = identify(capsys, *words, "__ns:=/space")
    assert (status, output) == (2, "")
    assert errors.splitlines()[-1] == f"identify: {why.format(folder=tmp_path)}"
    assert "Traceback" not in errors and not list(tmp_path.iterdir())


def test_identify_without_options_drives_the_motor_of_its_namespace(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    experiment = mock.Mock()
    monkeypatch.setattr(identify_command, "LiveExperiment", experiment)
    monkeypatch.setattr(identify_command, "run", lambda name, make: make(name))
    assert identify(capsys) == (0, "", "")
    drive = experiment.call_args[0][1]
    assert drive == ("motor_input/input", "motor_output/output", 0.0, 1.0, 10.0)


@pytest.mark.parametrize("seconds", [1.0, 3600.0])
def test_identify_drives_a_plant_as_told_and_writes_its_files(
    seconds: float,
    tmp_path: pathlib.Path,
    monkeypatch: "pytest.MonkeyPatch",
    capsys: "pytest.CaptureFixture[str]",
) -> None:
    experiment = mock.Mock()
    monkeypatch.setattr(identify_command, "LiveExperiment", experiment)
    run = mock.Mock(side_effect=lambda name, make: make("node"))
    monkeypatch.setattr(identify_command, "run", run)
    limits = ["--least", "-0.5", "--largest", "2", "--seconds", str(seconds)]
    model, picture = tmp_path / "m.YML", tmp_path / "p.svg"
    files = ["--model", str(model), "--picture", str(picture)]
    assert identify(capsys, "--input", "a/b", "--output", "c/d", *limits, *files) == (0, "", "")
    assert run.call_args[0][0] == "identify" and not list(tmp_path.iterdir())
    node, drive, report = experiment.call_args[0]
    assert (node, drive) == ("node", ("a/b", "c/d", -0.5, 2.0, seconds))
    record = answered([(1.0, 1.0)], Model(4.0, 1.0), 9.0, outputs=200)
    report(record)
    found = identify_plant(record)
    assert capsys.readouterr().out == as_text(record, found, read_step(record)) + "\n"
    assert model.read_text() == as_yaml(found, "c/d over a/b")
    assert picture.read_text() == as_picture(record, found)


def test_identify_that_cannot_drive_the_plant_says_why(
    monkeypatch: "pytest.MonkeyPatch", capsys: "pytest.CaptureFixture[str]"
) -> None:
    refuse = mock.Mock(side_effect=DriveError("/motor_input: driven by another node"))
    monkeypatch.setattr(identify_command, "run", refuse)
    assert identify(capsys) == (2, "", "identify: /motor_input: driven by another node\n")
    refuse.side_effect = FieldError("/motor_input/x: unknown field 'x'")
    assert identify(capsys) == (2, "", "identify: /motor_input/x: unknown field 'x'\n")
    monkeypatch.setattr(identify_command, "run", mock.Mock(side_effect=KeyboardInterrupt))
    assert identify(capsys) == (130, "", "")


def test_identify_bag_with_any_two_fields_is_accepted(
    tmp_path: pathlib.Path, capsys: "pytest.CaptureFixture[str]"
) -> None:
    path = str(tmp_path / "run.bag")
    with rosbag.Bag(path, "w") as bag:
        for number in range(1000):
            time = rospy.Time.from_sec(100.0 + 0.01 * number)
            given = 0.5 if number >= 200 else 0.0
            speed = 0.0 if number < 200 else 4.0 * (1.0 - 0.98 ** (number - 200))
            if number in (100, 200):
                bag.write("/a/given", motor_input(given, 0.0), time)
            late = rospy.Duration.from_sec(0.004 * (number % 2))
            bag.write("/a/done", motor_output(speed, 0.01 * number, ""), time + late)
        bag.write("/a/given", motor_input(0.0, 0.0), rospy.Time.from_sec(109.999))
        # Other topics are not read: this one is unreadable.
        broken = (String._type, b"", String._md5sum, String)
        bag.write("/a/other", broken, rospy.Time.from_sec(105.0), raw=True)
    fields = ["--input", "/a/given/input", "--output", "/a/done/output"]
    times = read_record(path, fields[1], fields[3]).times
    assert numpy.diff(times) == pytest.approx(0.01)  # by the stamps
    same = read_record(path, fields[3].replace("output", "time"), fields[3])
    assert len(same.inputs) == 1000
    assert same.inputs[-1] == pytest.approx(9.99) and same.outputs[-1] == pytest.approx(4.0)
    files = ["--model", str(tmp_path / "m.yaml"), "--picture", str(tmp_path / "p.svg")]
    status, output, errors = identify(capsys, path, *fields, *files)
    assert (status, errors) == (0, "")
    origin = f"# Identified from {fields[3]} over {fields[1]} in {path}.\n"
    assert (tmp_path / "m.yaml").read_text().startswith(origin)
    assert (tmp_path / "p.svg").read_text().count("<polyline") >= 4
    assert output.startswith("9.99 s, 1000 outputs, 2 changes of the input\n")
    (line,) = [line for line in output.splitlines() if line.startswith("K   ")]
    assert float(line.split()[1]) == pytest.approx(8.0, abs=0.01)
    status, _, errors = identify(capsys, path, *fields, "--start", "0.5", "--end", "1.5")
    why = f"identify: {path}: record not usable: "
    assert (status, errors) == (1, f"{why}the input never changes: it is 0 throughout\n")
    status, output, errors = identify(capsys, path, *fields, "--start", "1.5", "--end", "9")
    assert (status, errors) == (0, "")
    assert output.startswith("7.5 s, 751 outputs, 1 changes of the input")
    status, _, errors = identify(capsys, path, *fields[:2], "--output", "/a/done/speed")
    assert status == 2
    has = "it has: output, time, status"
    assert errors == f"identify: {path}: /a/done/speed: unknown field 'speed'; {has}\n"
    (tmp_path / "x.bag").write_text("no bag")
    status, _, errors = identify(capsys, str(tmp_path / "x.bag"), *fields)
    assert status == 2 and errors.startswith(f"identify: {tmp_path}/x.bag: ")
    status, _, errors = identify(capsys, path, *fields, "--start", "11")
    assert (status, errors) == (1, f"{why}/a/done/output is not in this part of the bag\n")
    full = OSError(28, "No space left on device", "m.yaml")
    with mock.patch.object(identify_command, "write_file", side_effect=full):
        status, _, errors = identify(capsys, path, *fields, *files)
    assert (status, errors) == (2, "identify: m.yaml: No space left on device\n")
