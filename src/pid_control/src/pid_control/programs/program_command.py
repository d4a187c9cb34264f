"""Command that starts a controller: a program, or one node of a launch file."""

import contextlib
import difflib
import os
import shlex
import subprocess
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Set, Tuple

import roslaunch.config
import roslaunch.substitution_args
import roslaunch.xmlloader
import rospkg
from rosgraph.names import get_ros_namespace, ns_join
from roslaunch.core import Node, local_machine, setup_env
from roslaunch.node_args import NodeParamsException, create_local_process_args

from pid_control.programs.package_messages import package_name
from pid_control.programs.python_program import start_words

#: Timeout for reading the environment of a workspace [s].
_ENVIRONMENT_S = 20.0
#: Topics of the loop.
_TOPICS = ("motor_input", "motor_output", "set_point")
#: Smallest similarity of a suggested name, from 0 to 1.
_NEAR = 0.75


class CommandError(Exception):
    """Error of a controller that cannot be found or started; the text gives the reason."""


class ProgramCommand(NamedTuple):
    """Command that starts a controller.

    :ivar name: name in reports
    :ivar argv: the program and its arguments
    :ivar environment: all environment variables
    :ivar parameters: parameters to set, by global name
    :ivar of_others: private parameters of the other nodes of its launch file, by global name
    :ivar package: folder of its package; empty without one
    :ivar notes: repairs that were needed to start it, and files found for it
    """

    name: str
    argv: List[str]
    environment: Dict[str, str]
    parameters: Dict[str, Any]
    of_others: Dict[str, Any]
    notes: Sequence[str] = ()
    package: str = ""


def find_controller(
    words: Sequence[str],
    node: Optional[str] = None,
    workspace: Optional[str] = None,
    launch: Optional[str] = None,
) -> ProgramCommand:
    """Find the controller that a command line names.

    :param words: a path and arguments, or a package, a name in it and arguments; as for rosrun with
        a program, as for roslaunch with a launch file
    :param node: name of the node in a launch file; by default the node whose name or program
        contains "control"
    :param workspace: the controller's workspace if not this one: its folder, devel or install
    :param launch: launch file that starts the program and has its parameters; by default one of its
        package, if the program has no arguments
    :raises CommandError: if the controller cannot be found
    """
    environment = workspace_environment(workspace) if workspace is not None else dict(os.environ)
    path, arguments = _path(words, environment)
    package = _package_of(path, words, environment)
    if path.endswith(".launch"):
        if launch is not None:
            raise CommandError(f"--launch: only valid with a program ({path})")
        found = _command_of_launch_file(path, arguments, node, environment, package)
        return found._replace(package=package)
    if node is not None:
        raise CommandError(f"--node: only valid with a launch file ({path})")
    start, notes = _start(path, environment)
    command = ProgramCommand(path, [*start, *arguments], environment, {}, {}, notes, package)
    if arguments and launch is None:
        return command  # run with the given arguments
    return _with_launch_file(command, path, launch)


def _package_of(path: str, words: Sequence[str], environment: Dict[str, str]) -> str:
    """Return the folder of a file's package, or of the named one; empty without one."""
    folder = os.path.dirname(os.path.realpath(path))
    while folder != os.path.dirname(folder):
        if os.path.isfile(os.path.join(folder, "package.xml")):
            return folder
        folder = os.path.dirname(folder)
    folder, name = os.path.dirname(path), words[0]
    if folder in _libexec_folders(environment, os.path.basename(folder)):
        name = os.path.basename(folder)
    with contextlib.suppress(rospkg.ResourceNotFound):  # a program of a built workspace
        return str(rospkg.RosPack(rospkg.get_ros_paths(env=environment)).get_path(name))
    return ""


def _with_launch_file(command: ProgramCommand, path: str, launch: Optional[str]) -> ProgramCommand:
    """Return a command with the parameters and names that a launch file has for its program."""
    files = [launch] if launch is not None else _launch_files(command.package, path)
    problems: List[str] = []
    for file in files:
        try:
            with package_environment(command.package, command.environment):
                config = load_launch_file(file, [])
                nodes = [one for one in config.nodes if one.type == os.path.basename(path)]
                if not nodes:
                    continue
                variables = setup_env(nodes[0], local_machine(), "", command.environment)
            arguments = shlex.split(nodes[0].args or "")
        except Exception as error:  # of any type: $(eval …) runs the student's code
            problems.append(f"{file} cannot be used: {' '.join(str(error).split())[:200]}")
            continue
        node = nodes[0]
        parameters, of_others = _split_parameters(config, node)
        _connect_to_judge(node)
        names = [f"__name:={node.name}", *(f"{old}:={new}" for old, new in node.remap_args)]
        return command._replace(
            argv=[*command.argv, *arguments, *names],
            environment=variables,
            parameters=parameters,
            of_others=of_others,
            notes=[*command.notes, f"{file}: its parameters and names for {_name(node)} are used"],
        )
    if launch is not None:
        why = problems[0] if problems else f"{launch} does not start {os.path.basename(path)}"
        raise CommandError(f"--launch: {why}")
    return command._replace(notes=[*command.notes, *problems])


def _launch_files(package: str, path: str) -> List[str]:
    """Return the launch files of a package that name a program or cannot be read."""
    found = []
    for file in sorted(files_in(package)) if package else []:
        if file.endswith(".launch"):
            try:
                with open(file, encoding="utf-8", errors="replace") as opened:
                    names_it = os.path.basename(path) in opened.read()
            except OSError:
                names_it = True  # roslaunch reports its error
            if names_it:
                found.append(file)
    return found


@contextlib.contextmanager
def package_environment(package: str, environment: Mapping[str, str]) -> Iterator[None]:
    """Set a program's environment, in which $(find …) finds its package, not one of the same name.

    :param package: folder of the package; empty without one
    :param environment: environment variables of the program
    """
    before = dict(os.environ)
    os.environ.update(environment)
    if package and not _is_found(package, environment):
        paths = [package, environment.get("ROS_PACKAGE_PATH", "")]
        os.environ["ROS_PACKAGE_PATH"] = os.pathsep.join(filter(None, paths))
        os.environ.pop("CMAKE_PREFIX_PATH", None)  # its workspaces would come before these paths
    roslaunch.substitution_args._rospack = None  # it keeps the paths of its first use
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)
        roslaunch.substitution_args._rospack = None


def _is_found(package: str, environment: Mapping[str, str]) -> bool:
    with contextlib.suppress(rospkg.ResourceNotFound):
        places = rospkg.RosPack(rospkg.get_ros_paths(env=dict(environment)))
        return os.path.samefile(places.get_path(package_name(package)), package)
    return False


def load_launch_file(path: str, arguments: Sequence[str]) -> Any:
    """Return the configuration of a launch file, without roscore.xml, which runs two commands.

    :param path: path of the launch file
    :param arguments: its arguments, ``NAME:=VALUE``
    :returns: roslaunch's ROSLaunchConfig
    :raises Exception: of any kind if it cannot be loaded: $(eval …) runs what the student wrote
    """
    config = roslaunch.config.ROSLaunchConfig()
    roslaunch.xmlloader.XmlLoader().load(path, config, argv=list(arguments), verbose=False)
    config.assign_machines()
    return config


def _split_parameters(config: Any, node: Node) -> Tuple[Dict[str, Any], Dict[str, Any]]:
    """Return the parameters of a launch file for a node, and the private ones of the others."""
    own = _name(node) + "/"
    others = tuple(_name(other) + "/" for other in config.nodes if other is not node)
    parameters: Dict[str, Any] = {}
    of_others: Dict[str, Any] = {}
    for key, parameter in config.params.items():
        is_others = key.startswith(others) and not key.startswith(own)
        (of_others if is_others else parameters)[key] = parameter.value
    return parameters, of_others


def _start(path: str, environment: Dict[str, str]) -> Tuple[Sequence[str], Sequence[str]]:
    start, notes = start_words(path, environment)
    if not notes and not os.access(path, os.X_OK):
        raise CommandError(f"{path} is not executable: chmod +x {path}")
    return start, notes


def _path(words: Sequence[str], environment: Dict[str, str]) -> Tuple[str, List[str]]:
    first, rest = words[0], list(words[1:])
    if os.path.isfile(first):
        return os.path.abspath(first), rest
    if os.sep in first:
        raise CommandError(f"file not found ({first})")
    if not rest:
        raise CommandError(f"file not found ({first}); for a package, name a program in it as well")
    name = rest.pop(0)
    rospack = rospkg.RosPack(rospkg.get_ros_paths(env=environment))
    try:
        place = rospack.get_path(first)
    except rospkg.ResourceNotFound:
        raise CommandError(f"package not found in ROS_PACKAGE_PATH ({first})") from None
    found = find_files(place, name)
    if name.endswith(".py") or not found:
        # Built and installed programs are in another folder.
        found = [*_libexec(environment, first, name), *found]
    if not found:
        near = near_names(name, place, *_libexec_folders(environment, first))
        raise CommandError(f"{name}: not found in the package {first} ({place}){near}")
    return found[0], rest


def find_files(place: str, name: str) -> List[str]:
    """Return the files with a name below a folder, executable ones first; skip hidden folders.

    :param place: the folder
    :param name: name of the file
    """
    found = [path for path in files_in(place) if os.path.basename(path) == name]
    return sorted(found, key=lambda path: (not os.access(path, os.X_OK), path))


def near_names(name: str, *places: str) -> str:
    """Return a hint with the programs and launch files whose names resemble a name, if any.

    :param name: the name
    :param places: folders; hidden folders in them are skipped
    """
    names: Dict[str, Set[str]] = {}
    for path in (path for place in places for path in files_in(place)):
        if path.endswith((".py", ".launch")) or os.access(path, os.X_OK):
            names.setdefault(os.path.basename(path).lower(), set()).add(os.path.basename(path))
    near = difflib.get_close_matches(name.lower(), names, cutoff=_NEAR)
    found = [one for lower in near for one in sorted(names[lower])]
    return f"; did you mean {' or '.join(found)}?" if found else ""


def files_in(place: str) -> Iterator[str]:
    """Yield the paths of all files below a folder; skip hidden folders.

    :param place: the folder
    """
    for folder, folders, files in os.walk(place):
        folders[:] = [child for child in folders if not child.startswith(".")]
        yield from (os.path.join(folder, file) for file in files)


def _libexec(environment: Dict[str, str], package: str, name: str) -> List[str]:
    paths = [os.path.join(place, name) for place in _libexec_folders(environment, package)]
    return [path for path in paths if os.path.isfile(path)]


def _libexec_folders(environment: Dict[str, str], package: str) -> List[str]:
    prefixes = environment.get("CMAKE_PREFIX_PATH", "").split(os.pathsep)
    return [os.path.join(prefix, "lib", package) for prefix in prefixes if prefix]


def workspace_environment(workspace: str) -> Dict[str, str]:
    """Return the environment of a workspace.

    :param workspace: its folder, devel or install
    :raises CommandError: if it is not built
    """
    places = [os.path.join(workspace, part) for part in ("devel", "install", "")]
    scripts = [os.path.join(place, "env.sh") for place in places]
    found = [script for script in scripts if os.path.isfile(script)]
    if not found:
        raise CommandError(f"{workspace}: not a built workspace; devel/env.sh is missing")
    try:
        done = subprocess.run(
            [found[0], "env", "-0"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            timeout=_ENVIRONMENT_S,
            check=True,
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise CommandError(f"{found[0]} fails: {error}") from None
    pairs = (entry.partition("=") for entry in done.stdout.decode().split("\0"))
    return {name: value for name, is_one, value in pairs if is_one}


def _command_of_launch_file(
    path: str,
    arguments: List[str],
    wanted: Optional[str],
    environment: Dict[str, str],
    package: str,
) -> ProgramCommand:
    try:
        with package_environment(package, environment):
            config = load_launch_file(path, arguments)
            node = _choose(config.nodes, wanted, path)
            _connect_to_judge(node)
            command = _words_of(node)
            variables = setup_env(node, local_machine(), "", environment)
    except CommandError:
        raise
    except Exception as error:  # of any type: $(eval …) runs the student's code
        raise CommandError(f"{path}: {error}") from None
    start, notes = start_words(command[0], variables)
    parameters, of_others = _split_parameters(config, node)
    name, command = f"{path} {_name(node)}", [*start, *command[1:]]
    return ProgramCommand(name, command, variables, parameters, of_others, notes)


def _words_of(node: Node) -> List[str]:
    """Return the words that start a node of a launch file; its program need not be executable."""
    environment = dict(os.environ)
    with contextlib.suppress(NodeParamsException):
        return list(create_local_process_args(node, local_machine(), environment))
    path, _ = _path([node.package, node.type], environment)
    _start(path, environment)  # only a Python script can be started
    remappings = [f"{old}:={new}" for old, new in node.remap_args]
    return [path, *shlex.split(node.args or ""), *remappings, f"__name:={node.name}"]


def _connect_to_judge(node: Node) -> None:
    """Remap the topics of the loop to the judge's, if a launch file has a namespace of its own."""
    base = get_ros_namespace()
    own = {ns_join(node.namespace, topic): ns_join(base, topic) for topic in _TOPICS}
    if node.namespace == base:
        return
    pairs = [(old, own.get(ns_join(node.namespace, new), new)) for old, new in node.remap_args]
    kept = {ns_join(node.namespace, old) for old, _ in pairs}
    node.remap_args = [*pairs, *(pair for pair in own.items() if pair[0] not in kept)]


def _name(node: Node) -> str:
    return str(node.namespace) + str(node.name)


def _choose(nodes: List[Node], wanted: Optional[str], path: str) -> Node:
    names = ", ".join(_name(node) for node in nodes) or "none"
    if wanted is not None:
        found = [node for node in nodes if wanted in (_name(node), node.name)]
        if len(found) != 1:
            raise CommandError(f"{path} has no node {wanted}; its nodes are {names}")
        return found[0]
    found = [node for node in nodes if "control" in (node.name + node.type).lower()]
    found = found or nodes
    if len(found) != 1:
        raise CommandError(f"{path}: which node is the controller? --node NAME, of {names}")
    return found[0]
