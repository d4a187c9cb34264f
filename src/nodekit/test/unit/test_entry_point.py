"""What a node's process settles before anything heavy is imported."""

import subprocess
import sys

RUN = "import sys; from nodekit.entry_point import main; main('%s')"


def run_main(tmp_path, text):
    """Run the entry point on a module with this text; return the finished process."""
    (tmp_path / "some_node.py").write_text(text)
    program = "import sys; sys.path.insert(0, %r); %s" % (str(tmp_path), RUN % "some_node")
    return subprocess.run(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def test_messages_are_imported_without_numpy(tmp_path):
    text = (
        "import genpy, sys\n"
        "def main():\n"
        "    sys.exit(5 if sys.modules['numpy'] is None and genpy.Message else 6)\n"
    )
    assert run_main(tmp_path, text).returncode == 5


def test_interrupt_during_the_imports_is_no_error(tmp_path):
    done = run_main(tmp_path, "raise KeyboardInterrupt\n")
    assert (done.returncode, done.stderr) == (0, b"")


def test_search_for_files_is_imported_when_it_is_needed(tmp_path):
    text = (
        "import roslib.packages, sys\n"
        "def main():\n"
        "    assert 'pyparsing' not in sys.modules\n"
        "    for _ in range(2):\n"
        "        files = roslib.packages.catkin_find(project='basic_comms', path='package.xml')\n"
        "    sys.exit(5 if files and 'pyparsing' in sys.modules else 6)\n"
    )
    done = run_main(tmp_path, text)
    assert done.returncode == 5, done.stderr
