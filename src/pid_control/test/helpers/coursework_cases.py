"""Courseworks with flaws: a good one, edited. Flaws that hide no other share a coursework."""

import pathlib
import shutil
from typing import NamedTuple, Sequence, Tuple

import rospkg

COURSEWORKS = pathlib.Path(rospkg.RosPack().get_path("pid_control")) / "test" / "courseworks"
GOOD = ("wave_loops", "sine_classes", "magnitude_vectors", "included_arguments")
GENERATOR, PROCESS = "scripts/signal_generator.py", "scripts/process.py"


class Case(NamedTuple):
    """A flawed coursework.

    :ivar name: name of the case
    :ivar base: the good coursework that it is made from
    :ivar edits: file, and a text in it to replace
    :ivar scenarios: scenarios to run
    :ivar flaws: flaws that the judge has to name, no others
    :ivar says: a part of the sentence of each cause
    """

    name: str
    base: str
    edits: Sequence[Tuple[str, str, str]]
    scenarios: Sequence[str]
    flaws: Sequence[str]
    says: Sequence[str]


def make(case: Case, folder: pathlib.Path) -> pathlib.Path:
    """Make the package of a case in a folder, and return its own."""
    package = folder / case.name / case.base
    shutil.copytree(str(COURSEWORKS / case.base), str(package))
    for file, old, new in case.edits:
        path = package / file
        text = path.read_text()
        assert old in text, (case.name, old)
        path.write_text(text.replace(old, new))
    return package


BELOW_ZERO = Case(
    "below_zero",
    "wave_loops",
    [("config/params.yaml", "process_offset: 1.5", "process_offset: 0.25")],
    ["process"],
    ["negative"],
    ["where at least 1 is needed, or a rectifier"],
)
FLAWED = (
    Case(
        "crash",
        "wave_loops",
        [(PROCESS, "gain * shifted", "gain * shiftd")],
        ["signal", "process"],
        ["crash"],
        ["/process ended by itself: NameError: name 'shiftd' is not defined"],
    ),
    Case(
        "other_topic",
        "wave_loops",
        [
            (PROCESS, 'Subscriber("signal"', 'Subscriber("Signal"'),
            (PROCESS, 'Subscriber("time"', 'Subscriber("Time"'),
        ],
        ["signal"],
        ["not connected"],
        ["process.py publishes /proc_signal (std_msgs/Float32) and subscribes to /Signal"],
    ),
    Case(
        "flood",
        "wave_loops",
        [(GENERATOR, "        rate.sleep()\n", "")],
        ["signal"],
        ["flood"],
        ["/signal_generator computes without a pause: a loop without rospy.Rate"],
    ),
    Case(
        "one_node",
        "wave_loops",
        [
            (
                "launch/cw1.launch",
                'type="process.py" output="screen"/>',
                'type="process.py" if="0"/>',
            )
        ],
        ["launch"],
        ["launch"],
        ["no launch file starts both nodes: launch/cw1.launch starts 1 node of it"],
    ),
    Case(
        "constant_seldom_and_absolute",
        "wave_loops",
        [
            (GENERATOR, "rospy.Rate(10)", "rospy.Rate(4)"),
            (PROCESS, "    global signal_data\n", ""),
            (PROCESS, "    global time_data\n", ""),
            (PROCESS, 'Publisher("proc_signal"', 'Publisher("/proc_signal"'),
        ],
        ["signal", "process", "namespace"],
        ["constant", "too seldom", "namespace"],
        [
            "/proc_signal/data is constant, whatever the signal",
            "the signal generator sends too seldom: its loop is slower than 10 Hz",
            "/proc_signal stays outside the namespace of the nodes",
        ],
    ),
    Case(
        "silent_after_a_triangle",
        "wave_loops",
        [
            (GENERATOR, "np.sin(omega * time)", "np.arcsin(np.sin(omega * time))"),
            (PROCESS, "        pub.publish(gain * shifted + offset)\n", ""),
        ],
        ["signal", "process"],
        ["silent", "distorted"],
        ["the process node sends nothing", "/signal/data is not a sine"],
    ),
    Case(
        "root_below_zero",
        "included_arguments",
        [("scripts/process_node.py", "np.sqrt(1.0 - x**2)", "np.sqrt(0.9 - x**2)")],
        ["process"],
        ["nan"],
        ["the process node sends NaN: one of: the root of a number below 0"],
    ),
    Case(
        "fields_not_filled_and_too_little_processed",
        "sine_classes",
        [
            ("scripts/source.py", "Wave(self.amplitude, self.", "Wave(0.0, self."),
            ("scripts/processor.py", "wave.amplitude", "1.5"),
            (
                "launch/both.launch",
                'name="phase_shift" value="-0.8"',
                'name="phase_shift" value="0"',
            ),
            ("launch/both.launch", 'name="offset" value="1.0"', 'name="offset" value="0.1"'),
        ],
        ["signal", "process"],
        ["fields", "unchanged", "negative"],
        [
            "the messages have amplitude 0, frequency 0.4, but the signal's amplitude is 1.5",
            "the process node does not shift the phase",
            "its offset is 0.1, where at least 0.375 is needed, or a rectifier",
        ],
    ),
    Case(
        "own_clock",
        "wave_loops",
        [
            (PROCESS, "signal_data * np", "amplitude * np.sin(omega * rospy.get_time()) * np"),
            (PROCESS, "omega * time_data", "omega * rospy.get_time()"),
        ],
        ["restart"],
        ["free-running"],
        ["the output keeps oscillating without a signal"],
    ),
    Case(
        "counted_time",
        "wave_loops",
        [(PROCESS, "    time_data = msg.data\n", "    time_data += 0.1\n")],
        ["restart"],
        ["restart"],
        ["after a restart of the generator the output differs"],
    ),
    Case(
        "hard_coded_beside_yaml_not_loaded",
        "wave_loops",
        [
            ("launch/cw1.launch", 'command="load"', 'command="load" if="0"'),
            (GENERATOR, 'rospy.get_param("signal_amplitude", 1.0)', "1.0"),
            (GENERATOR, 'rospy.get_param("signal_omega", 1.0)', "3.0"),
            (PROCESS, 'rospy.get_param("signal_omega", 1.0)', "3.0"),
        ],
        ["parameters", "yaml"],
        ["hard-coded", "yaml"],
        [
            "no parameter affects the signal generator",
            "params.yaml: cw1.launch loads it, but sets other values",
        ],
    ),
)

#: A good coursework with a loop that counts, and is faster than the steps of the clock.
FAST = Case(
    "fast",
    "included_arguments",
    [
        ("scripts/sig_gen.py", "rospy.Rate(50)", "rospy.Rate(250)"),
        ("scripts/sig_gen.py", "t += 0.02", "t += 0.004"),
    ],
    ["signal", "process"],
    [],
    [],
)
