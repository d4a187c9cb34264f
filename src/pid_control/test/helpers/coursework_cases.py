"""Courseworks with one flaw each: a good one, edited."""

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
    :ivar says: a part of the sentence of the cause
    """

    name: str
    base: str
    edits: Sequence[Tuple[str, str, str]]
    scenarios: Sequence[str]
    flaws: Sequence[str]
    says: str


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


FLAWED = (
    Case(
        "crash",
        "wave_loops",
        [(PROCESS, "gain * shifted", "gain * shiftd")],
        ["signal", "process"],
        ["crash"],
        "/process ended by itself: NameError: name 'shiftd' is not defined",
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
        "process.py publishes /proc_signal (std_msgs/Float32) and subscribes to /Signal",
    ),
    Case(
        "flood",
        "wave_loops",
        [(GENERATOR, "        rate.sleep()\n", "")],
        ["signal"],
        ["flood"],
        "/signal_generator computes without a pause: a loop without rospy.Rate",
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
        "no launch file starts both nodes: launch/cw1.launch starts 1 node of it",
    ),
    Case(
        "constant_output",
        "wave_loops",
        [(PROCESS, "    global signal_data\n", ""), (PROCESS, "    global time_data\n", "")],
        ["process"],
        ["constant"],
        "/proc_signal/data is constant, whatever the signal",
    ),
    Case(
        "silent_process",
        "wave_loops",
        [(PROCESS, "        pub.publish(gain * shifted + offset)\n", "")],
        ["signal", "process"],
        ["silent"],
        "the process node sends nothing",
    ),
    Case(
        "too_seldom",
        "wave_loops",
        [(GENERATOR, "rospy.Rate(10)", "rospy.Rate(4)")],
        ["signal"],
        ["too seldom"],
        "the signal generator sends too seldom: its loop is slower than 10 Hz",
    ),
    Case(
        "triangle",
        "wave_loops",
        [(GENERATOR, "np.sin(omega * time)", "np.arcsin(np.sin(omega * time))")],
        ["signal"],
        ["distorted"],
        "/signal/data is not a sine",
    ),
    Case(
        "root_below_zero",
        "included_arguments",
        [("scripts/process_node.py", "np.sqrt(1.0 - x**2)", "np.sqrt(0.9 - x**2)")],
        ["process"],
        ["nan"],
        "the process node sends NaN: one of: the root of a number below 0",
    ),
    Case(
        "frequency_in_turns",
        "wave_loops",
        [(GENERATOR, "np.sin(omega * time)", "np.sin(2.0 * omega * time)")],
        ["signal", "parameters"],
        ["frequency"],
        "the frequency is 6 rad/s, where /signal_omega is 3, in rad/s or Hz",
    ),
    Case(
        "fields_not_filled",
        "sine_classes",
        [
            ("scripts/source.py", "Wave(self.amplitude, self.", "Wave(0.0, self."),
            ("scripts/processor.py", "wave.amplitude", "1.5"),
        ],
        ["signal", "process"],
        ["fields"],
        "the messages have amplitude 0, frequency 0.4, but the signal's amplitude is 1.5",
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
        "the output keeps oscillating without a signal",
    ),
    Case(
        "counted_time",
        "wave_loops",
        [(PROCESS, "    time_data = msg.data\n", "    time_data += 0.1\n")],
        ["restart"],
        ["restart"],
        "after a restart of the generator the output differs",
    ),
    Case(
        "same_phase",
        "wave_loops",
        [("config/params.yaml", "process_angle: 1.2", "process_angle: 0.0")],
        ["process"],
        ["unchanged"],
        "the process node does not shift the phase",
    ),
    Case(
        "below_zero",
        "wave_loops",
        [("config/params.yaml", "process_offset: 1.5", "process_offset: 0.25")],
        ["process"],
        ["negative"],
        "where at least 1 is needed, or a rectifier",
    ),
    Case(
        "hard_coded",
        "wave_loops",
        [
            ("launch/cw1.launch", 'command="load"', 'command="load" if="0"'),
            (GENERATOR, 'rospy.get_param("signal_amplitude", 1.0)', "1.0"),
            (GENERATOR, 'rospy.get_param("signal_omega", 1.0)', "3.0"),
            (PROCESS, 'rospy.get_param("signal_omega", 1.0)', "3.0"),
        ],
        ["parameters"],
        ["hard-coded"],
        "no parameter affects the signal generator",
    ),
    Case(
        "not_used",
        "wave_loops",
        [
            (GENERATOR, "np.sin(omega * time)", "np.sin(3.0 * time)"),
            (PROCESS, "np.cos(omega * time_data)", "np.cos(3.0 * time_data)"),
        ],
        ["parameters"],
        ["unread"],
        "/signal_omega has no effect: one of: it is not read, or read and not used",
    ),
    Case(
        "yaml_not_loaded",
        "wave_loops",
        [("launch/cw1.launch", 'params.yaml" command="load"', 'params.yaml" if="0"')],
        ["yaml"],
        ["yaml"],
        "params.yaml: cw1.launch loads it, but sets other values",
    ),
    Case(
        "absolute_name",
        "wave_loops",
        [(PROCESS, 'Publisher("proc_signal"', 'Publisher("/proc_signal"')],
        ["namespace"],
        ["namespace"],
        "/proc_signal stays outside the namespace of the nodes",
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
    "passed: all ",
)
