"""Student's package: search for the nodes to start, by launch file or names of programs."""

import contextlib
import os
import re
import shlex
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Set, Tuple

import rospkg
import yaml
from roslaunch.core import Node, local_machine, setup_env

from pid_control.programs.package_messages import package_name
from pid_control.programs.program_command import (
    CommandError,
    ProgramCommand,
    files_in,
    find_files,
    load_launch_file,
    package_environment,
)
from pid_control.programs.program_finder import builds
from pid_control.programs.python_program import start_words
from pid_control.signal_judging.parameter_roles import is_number

#: Parts of the names of a process node, and of a signal generator.
_PROCESS, _GENERATOR = ("proc",), ("gen", "sig", "sin", "pub")
#: Names of parameters in a source: rospy.get_param("name", …), nh.param("name", …, …).
_READS = re.compile(
    r"""(?:get_param|getParam|[Pp]aram)\w*(?:<[^>]*>)?\(\s*["'](~?[\w/]+)["']\s*,?\s*([^\n),]*)"""
)
#: Starts of defaults that are not numbers, and the number for a default that is not a literal.
_NOT_NUMBERS, _UNKNOWN = ('"', "'", "True", "False", "[", "{", "true", "false"), 1.1
_SOURCES = (".py", ".cpp", ".cc", ".h", ".hpp")
#: Most nodes of a package that are started.
_MOST_NODES = 8


class StudentNode(NamedTuple):
    """A node of the coursework.

    :ivar name: name without its namespace
    :ivar namespace: its namespace, "/" or "/a/"
    :ivar program: name of its program
    :ivar command: command without name and namespace
    """

    name: str
    namespace: str
    program: str
    command: ProgramCommand

    @property
    def global_name(self) -> str:
        """Name with its namespace."""
        return self.namespace + self.name


class Coursework(NamedTuple):
    """Coursework of a student.

    :ivar folder: folder of the package
    :ivar package: name of the package
    :ivar launch_file: path of the launch file; empty without one
    :ivar nodes: nodes to start, likely process nodes first
    :ivar arguments: arguments of the launch file
    :ivar parameters: parameters of the launch file, by global name
    :ivar missing: why no launch file starts both nodes; empty if one does
    :ivar notes: repairs that were needed, choices, and omissions
    """

    folder: str
    package: str
    launch_file: str
    arguments: Sequence[str]
    nodes: Sequence[StudentNode]
    parameters: Mapping[str, Any]
    missing: str
    notes: Sequence[str]

    def numbers(self) -> Dict[str, Any]:
        """Return the parameters that are numbers."""
        return {name: value for name, value in self.parameters.items() if is_number(value)}

    def names_in_source(self, path: str) -> List[Tuple[str, float]]:
        """Return the parameters that a source reads, with a number as default; ``~`` for private.

        :param path: path of the source
        """
        found = []
        with contextlib.suppress(OSError):
            with open(path, encoding="utf-8", errors="replace") as file:
                for name, default in _READS.findall(file.read()):
                    if not default.startswith(_NOT_NUMBERS):
                        found.append((name, _number(default)))
        return found

    def mentions(self, name: str) -> bool:
        """Return True if a source has a word."""
        return any(
            re.search(rf"\b{re.escape(name)}\b", text) for text in self._sources(self._paths())
        )

    def quotes(self, name: str) -> bool:
        """Return True if a program of the nodes has a name in quotes; any source if it is built."""
        programs = [node.command.name for node in self.nodes]
        paths = programs if all(path.endswith(".py") for path in programs) else self._paths()
        end = re.compile(rf"""["'/~]{re.escape(name)}["']""")
        return any(end.search(text) for text in self._sources(paths))

    def _paths(self) -> List[str]:
        return [path for path in files_in(self.folder) if path.endswith(_SOURCES)]

    def _sources(self, paths: Sequence[str]) -> List[str]:
        found = []
        for path in paths:
            with contextlib.suppress(OSError):
                with open(path, encoding="utf-8", errors="replace") as file:
                    found.append(file.read())
        return found


def package_folder(word: str, environment: Mapping[str, str]) -> str:
    """Return the folder of a package.

    :param word: its folder, or its name
    :param environment: environment variables
    :raises CommandError: if there is no such package
    """
    if os.path.isdir(word):
        if not os.path.isfile(os.path.join(word, "package.xml")):
            raise CommandError(f"{word}: no package.xml in it: not a ROS package")
        return os.path.realpath(word)
    if os.sep in word:
        raise CommandError(f"folder not found ({word})")
    try:
        paths = rospkg.get_ros_paths(env=dict(environment))
        return str(rospkg.RosPack(paths).get_path(word))
    except rospkg.ResourceNotFound:
        raise CommandError(f"package not found in ROS_PACKAGE_PATH ({word})") from None


def find_coursework(
    folder: str, words: Sequence[str], environment: Dict[str, str], programs: Sequence[str] = ()
) -> Coursework:
    """Find the nodes of a coursework.

    :param folder: folder of the package
    :param words: a launch file of the package and its arguments, if given
    :param environment: environment variables of the nodes
    :param programs: programs to start instead of the found ones
    :raises CommandError: if there are no two nodes
    """
    name = package_name(folder)
    finder = _Finder(folder, name, environment, set(programs))
    if words:
        return finder.of_launch_file(_launch_file_of(folder, words[0]), list(words[1:]))
    return finder.of_package()


def has_coursework(folder: str) -> bool:
    """Return True if a package looks like this coursework, by the names of its programs."""
    names = [os.path.basename(path).lower() for path in files_in(folder) if _is_source(path)]
    processes = [name for name in names if _is_like(name, _PROCESS)]
    others = [name for name in names if _is_like(name, _GENERATOR) and name not in processes]
    return bool(processes) and bool(others)


def yaml_files(folder: str) -> List[str]:
    """Return the paths of the YAML files of a package."""
    paths = [path for path in files_in(folder) if path.endswith((".yaml", ".yml"))]
    return sorted(path for path in paths if not os.path.basename(path).startswith("."))


def launch_files(folder: str) -> List[str]:
    """Return the paths of the launch files of a package."""
    return sorted(path for path in files_in(folder) if path.endswith(".launch"))


def _launch_file_of(folder: str, word: str) -> str:
    if not word.endswith(".launch"):
        raise CommandError(f"must be a launch file of the package ({word})")
    if os.path.isfile(word):
        return os.path.realpath(word)
    found = [path for path in launch_files(folder) if os.path.basename(path) == word]
    if not found:
        there = ", ".join(os.path.basename(path) for path in launch_files(folder)) or "none"
        raise CommandError(f"launch file not found ({word}); the package has: {there}")
    return found[0]


def _is_source(path: str) -> bool:
    return path.endswith((".py", ".cpp", ".cc"))


def _is_like(name: str, parts: Tuple[str, ...]) -> bool:
    return any(part in name.lower() for part in parts)


class _Finder:
    """Search for the nodes of a package.

    :param folder: folder of the package
    :param name: name of the package
    :param environment: environment variables of the nodes
    :param programs: names of the only programs to start; empty for all
    """

    def __init__(
        self, folder: str, name: str, environment: Dict[str, str], programs: Set[str]
    ) -> None:
        self._folder, self._name, self._programs = folder, name, programs
        self._environment = environment
        self._notes: List[str] = []

    def of_launch_file(self, file: str, arguments: List[str]) -> Coursework:
        """Return the coursework that a launch file starts."""
        try:
            found, missing = self._load(file, arguments)
        except CommandError:
            raise
        except Exception as error:  # of any type: $(eval …) runs the student's code
            raise CommandError(f"{file}: {_one_line(error)}") from None
        if len(found.nodes) < 2:
            raise CommandError(f"{file}: {missing}")
        return found

    def of_package(self) -> Coursework:
        """Return the coursework of the launch file that fits best, or of programs by name."""
        best: Optional[Coursework] = None
        problems: List[str] = []
        for file in launch_files(self._folder):
            place = os.path.relpath(file, self._folder)
            try:
                found, missing = self._load(file, [])
            except Exception as error:  # of any type: $(eval …) runs the student's code
                problems.append(f"{place} cannot be loaded: {_one_line(error)}")
                continue
            if missing:
                problems.append(f"{place} {missing}")
            if len(found.nodes) >= 2 and _score(found) > (_score(best) if best else -1):
                best = found
        if best is not None and (_score(best) > 0 or len(self._by_names()) < 2):
            return best
        nodes = self._by_names()
        if best is not None:
            problems.append(f"{os.path.relpath(best.launch_file, self._folder)} starts other nodes")
        if len(nodes) < 2:
            why = "; ".join(problems) or "it has no launch file"
            raise CommandError(
                "no signal generator and process node found: no launch file starts two nodes of"
                f" the package ({why}), and no two programs have such names; name both:"
                " --nodes PROGRAM,PROGRAM"
            )
        missing = "; ".join(problems) or "the package has no launch file"
        names = " and ".join(node.program for node in nodes)
        notes = [*self._notes, f"{names} are started without a launch file"]
        return Coursework(self._folder, self._name, "", [], nodes, {}, missing, notes)

    def _load(self, file: str, arguments: List[str]) -> Tuple[Coursework, str]:
        """Load a launch file; return its coursework, and why it does not start two nodes."""
        with package_environment(self._folder, self._environment):
            config = load_launch_file(file, arguments)
        nodes: List[StudentNode] = []
        others: List[str] = []
        notes = list(self._notes)
        foreign: List[Node] = []
        for node in config.nodes:
            if node.package == self._name and (
                not self._programs or node.type in self._programs or node.name in self._programs
            ):
                nodes.append(self._of_launch_node(node, notes))
            else:
                others.append(f"{node.type} of {node.package}")
                foreign.append(node)
        place = os.path.relpath(file, self._folder)
        notes.append(f"launch file: {place}")
        if others:
            notes.append(f"not started: {', '.join(others)}")
        missing = ""
        if len(nodes) < 2:
            missing = f"starts {len(nodes) or 'no'} node{'s' if len(nodes) != 1 else ''} of it"
            same = [one for one in foreign if find_files(self._folder, one.type)]
            if same:
                missing += (
                    f": {same[0].type} is started from the package {same[0].package}, but this"
                    f" package is called {self._name}"
                )
        private = tuple(f"{node.namespace}{node.name}/" for node in foreign)
        parameters = {
            key: one.value for key, one in config.params.items() if not key.startswith(private)
        }
        nodes = [_with_parameters_of_arguments(one, parameters) for one in nodes]
        nodes = sorted(nodes, key=lambda one: not _is_like(one.name + one.program, _PROCESS))
        found = Coursework(
            self._folder, self._name, file, arguments, nodes[:_MOST_NODES], parameters, "", notes
        )
        return found, missing

    def _of_launch_node(self, node: Node, notes: List[str]) -> StudentNode:
        command = self._command(node.type, notes)
        variables = setup_env(node, local_machine(), "", command.environment)
        for name in ("ROS_NAMESPACE", "ROS_MASTER_URI"):
            variables.pop(name, None)
        remappings = [f"{old}:={new}" for old, new in node.remap_args]
        argv = [*command.argv, *shlex.split(node.args or ""), *remappings]
        command = command._replace(argv=argv, environment=variables)
        return StudentNode(node.name, node.namespace, node.type, command)

    def _command(self, program: str, notes: List[str]) -> ProgramCommand:
        found = [] if program.endswith(".py") else self._built(program)
        found += find_files(self._folder, program) + self._built(program)
        if not found:
            built = "; build its workspace, and use --workspace" * builds(self._folder, program)
            raise CommandError(f"{program}: not found in the package ({self._folder}){built}")
        start, repairs = start_words(found[0], self._environment)
        if not repairs and not os.access(found[0], os.X_OK):
            raise CommandError(f"{found[0]} is not executable: chmod +x {found[0]}")
        notes += [one for one in repairs if one not in notes]
        words, environment = list(start), dict(self._environment)
        return ProgramCommand(found[0], words, environment, {}, {}, package=self._folder)

    def _built(self, program: str) -> List[str]:
        prefixes = self._environment.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
        paths = [os.path.join(prefix, "lib", self._name, program) for prefix in prefixes if prefix]
        return [path for path in paths if os.path.isfile(path)]

    def _by_names(self) -> List[StudentNode]:
        """Return a process node and a generator by the names of the programs, if found."""
        programs = sorted(
            {
                os.path.basename(path)
                for path in files_in(self._folder)
                if path.endswith(".py") and _has_node(path)
            }
        )
        if self._programs:
            programs = sorted(self._programs)
        processes = [one for one in programs if _is_like(one, _PROCESS)]
        generators = [one for one in programs if _is_like(one, _GENERATOR) and one not in processes]
        chosen = [*processes[:1], *generators[:1]]
        if self._programs:
            chosen = sorted(programs, key=lambda one: one not in processes)
        notes = self._notes
        return [
            StudentNode(one.partition(".")[0], "/", one, self._command(one, notes))
            for one in chosen
        ]


def _with_parameters_of_arguments(node: StudentNode, parameters: Dict[str, Any]) -> StudentNode:
    """Move private parameters, ``_name:=value``, from a node's arguments to the others.

    A node sets those of its arguments when it starts: other values would have no effect.
    """
    argv = []
    for word in node.command.argv:
        name, is_remapping, text = word.partition(":=")
        if not is_remapping or not name.startswith("_") or name.startswith("__"):
            argv.append(word)
            continue
        try:
            parameters[f"{node.global_name}/{name[1:]}"] = yaml.safe_load(text)
        except yaml.YAMLError:
            argv.append(word)
    return node._replace(command=node.command._replace(argv=argv))


def _has_node(path: str) -> bool:
    with contextlib.suppress(OSError):
        with open(path, encoding="utf-8", errors="replace") as file:
            return "init_node" in file.read()
    return False


def _score(found: Coursework) -> int:
    names = [one.program + one.name for one in found.nodes]
    processes = [name for name in names if _is_like(name, _PROCESS)]
    others = [name for name in names if name not in processes and _is_like(name, _GENERATOR)]
    return bool(processes) + bool(others)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return _UNKNOWN


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:200]
