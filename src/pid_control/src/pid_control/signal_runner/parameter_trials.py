"""Trials with changed parameters (YAML, launch file, sources), to see which nodes use them."""

import os
import shutil
import tempfile
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import yaml

from pid_control.signal_judging.effects import changed_nodes, is_as_predicted
from pid_control.signal_judging.evidence import (
    GENERATOR,
    PROCESS,
    BaselineTrial,
    ParameterEffect,
    ParameterResults,
    TrialFeatures,
)
from pid_control.signal_judging.parameter_roles import (
    GENERATOR_ROLES,
    PROCESS_ROLES,
    changed,
    changed_text_or_list,
    is_number,
    role_of,
)
from pid_control.signal_runner.coursework import (
    Coursework,
    find_coursework,
    launch_files,
    yaml_files,
)
from pid_control.signal_runner.node_pair import NodePair
from pid_control.signal_runner.trial import NotConnectedError, TrialError

#: Most parameters that are tried one by one.
_MOST = 8
#: Distortion from which an output is not a sine.
_DISTORTED = 0.1


class ParameterTrials:
    """Trials of a coursework with other parameters.

    All numbers are changed together first, in YAML files of a copy of the package. Parameters
    without the effect that their names suggest are then changed one by one.

    :param coursework: the coursework
    :param pair: both nodes
    :param baseline: the trial of the unchanged coursework
    :param features: runs a coursework, and returns its features

    :ivar notes: notes on omissions
    """

    def __init__(
        self,
        coursework: Coursework,
        pair: NodePair,
        baseline: BaselineTrial,
        features: Callable[[Coursework], TrialFeatures],
    ) -> None:
        self._coursework, self._pair, self._features = coursework, pair, features
        self._before, self._own = baseline.features, baseline.own_parameters
        self._before_names = set(coursework.parameters)
        #: Names of the numbers in each YAML file that has any.
        self._numbered: Dict[str, Set[str]] = {}
        self.notes: List[str] = []

    def run(self) -> ParameterResults:
        """Run the trials.

        :returns: effects of the parameters
        """
        numbers = self._coursework.numbers()
        with tempfile.TemporaryDirectory(prefix="judge-") as scratch:
            copy, reached = self._copy_with_other_numbers(scratch)
            unused = self._unused(reached)
            wanted = {name: self._changed(name, value) for name, value in numbers.items()}
            wanted.update(
                {name: value for name, value in copy.numbers().items() if name in reached}
            )
            as_predicted = self._try_all(copy, wanted) if numbers else set()
        tried = [
            ParameterEffect(
                name,
                float(numbers[name]),
                self._role(name)[1],
                {self._role(name)[0]},
                is_predicted=True,
            )
            for name in sorted(as_predicted)
        ]
        rest = sorted(set(numbers) - as_predicted)
        if len(rest) > _MOST:
            self.notes.append(f"parameters not tried: {', '.join(rest[_MOST:])}")
        tried += [self._try_one(name, numbers[name]) for name in rest[:_MOST]]
        read = {node for one in tried for node in one.of}
        hidden = {
            node for node in (GENERATOR, PROCESS) if node not in read and self._reads_hidden(node)
        }
        parameters = ParameterResults(tried, hidden, unused, bool(self._numbered))
        unread = parameters.unread()
        idle = [one.name for one in tried if not one.of and one not in unread]
        if idle:
            self.notes.append(f"parameters without effect here: {', '.join(idle)}")
        return parameters

    def _copy_with_other_numbers(self, scratch: str) -> Tuple[Coursework, Set[str]]:
        """Copy the package with other numbers in its YAML files.

        :returns: the copy, and the parameters that differ in it
        """
        self._numbered.clear()
        if not self._coursework.launch_file:
            return self._coursework, set()
        folder = os.path.join(scratch, os.path.basename(self._coursework.folder))
        try:
            shutil.copytree(
                self._coursework.folder,
                folder,
                ignore=shutil.ignore_patterns(".git", "*.bag"),
                ignore_dangling_symlinks=True,
            )
        except OSError as error:
            self.notes.append(
                f"YAML files: not changed, because the package cannot be copied ({error})"
            )
            return self._coursework, set()
        for path in yaml_files(folder):
            with open(path, encoding="utf-8", errors="replace") as file:
                text = file.read()
            try:
                content = yaml.safe_load(text)
            except (yaml.YAMLError, RecursionError, ValueError):
                continue
            names = _names_of_numbers(content)
            if names:
                self._numbered[os.path.relpath(path, folder)] = names
                with open(path, "w", encoding="utf-8") as file:
                    yaml.safe_dump(self._other_numbers(content), file)
        if not self._numbered:
            return self._coursework, set()
        place = os.path.relpath(self._coursework.launch_file, self._coursework.folder)
        words = [os.path.join(folder, place), *self._coursework.arguments]
        environment = self._pair.generator.command.environment
        copy = find_coursework(folder, words, environment)
        before = self._coursework.numbers()
        differs = {
            name
            for name, value in copy.numbers().items()
            if name in before and value != before[name]
        }
        return copy, differs

    def _other_numbers(self, content: Any, name: str = "") -> Any:
        if isinstance(content, dict):
            return {key: self._other_numbers(one, str(key)) for key, one in content.items()}
        return self._changed("/" + name, content) if is_number(content) else content

    def _unused(self, reached: Set[str]) -> Mapping[str, str]:
        """Return the YAML files with numbers that do not reach the nodes, and why not."""
        texts = []
        for path in launch_files(self._coursework.folder):
            with open(path, encoding="utf-8", errors="replace") as file:
                texts.append((os.path.basename(path), file.read()))
        chosen = os.path.basename(self._coursework.launch_file)
        found = {}
        for path in sorted(self._numbered):
            name = os.path.basename(path)
            users = [file for file, text in texts if name in text]
            if users and reached:  # these files, or others with the same names
                continue
            if self._coursework.mentions(name):
                self.notes.append(f"{name}: the programs load it by themselves")
            elif chosen in users:
                found[name] = f"{chosen} loads it, but sets other values"
            elif users:
                self.notes.append(f"{name} is loaded by {', '.join(users)}, not by {chosen}")
            elif self._is_needed(self._numbered[path], bool(reached)):
                found[name] = "no launch file loads it"
        return found

    def _is_needed(self, names: Set[str], is_beside: bool) -> bool:
        """Return True if a source has one of these parameters, which are all unset.

        :param names: last names of the parameters
        :param is_beside: True if other files reach the nodes: then only their programs count
        """
        is_set = {name.rpartition("/")[2] for name in self._coursework.parameters}
        has = self._coursework.quotes if is_beside else self._coursework.mentions
        return not names & is_set and any(has(name) for name in names)

    def _try_all(self, copy: Coursework, wanted: Mapping[str, Any]) -> Set[str]:
        """Change all numbers; return the parameters with the effect that their names suggest."""
        numbers = self._coursework.numbers()
        try:
            parameters = {**copy.parameters, **wanted}
            after = self._features(copy._replace(parameters=parameters))
        except (TrialError, NotConnectedError):
            return set()  # found later, one by one
        if _is_distorted(after) and not _is_distorted(self._before):
            self.notes.append(
                "with other numbers the output is no longer a sine of the signal's frequency: one"
                " of: the process node has an amplitude or a frequency of its own, in its code or"
                " as a parameter, or the numbers do not fit together"
            )
        roles = [self._role(name) for name in numbers]
        return {
            name
            for name in numbers
            if roles.count(self._role(name)) == 1
            and is_as_predicted(
                self._role(name)[1],
                self._role(name)[0],
                (numbers[name], wanted[name]),
                self._before,
                after,
            )
        }

    def _try_one(self, name: str, value: Any) -> ParameterEffect:
        node, role = self._role(name)
        found: Set[str] = set()
        is_predicted = False
        for is_far in (True, False):  # a far value may be rejected
            new = changed(value, role, is_far)
            after = self._after({name: new})
            found = {GENERATOR, PROCESS} if after is None else changed_nodes(self._before, after)
            if found:
                is_predicted = after is not None and is_as_predicted(
                    role, node, (value, new), self._before, after
                )
                break
        others: List[str] = []
        last = name.rpartition("/")[2]
        if not found and self._coursework.mentions(last):
            names = [other for other in self._names_of(last) if other not in self._before_names]
            if self._effect({other: new for other in names}):
                others = [other for other in names if self._effect({other: new})]
        is_mentioned = self._coursework.mentions(last)
        return ParameterEffect(name, float(value), role, found, others, is_mentioned, is_predicted)

    def _effect(self, values: Mapping[str, Any]) -> Set[str]:
        """Return the nodes that change with parameters; all, if these end a trial."""
        after = self._after(values)
        return {GENERATOR, PROCESS} if after is None else changed_nodes(self._before, after)

    def _after(self, values: Mapping[str, Any]) -> Optional[TrialFeatures]:
        """Return the features with parameters; None if a node ends with them."""
        parameters = {**self._coursework.parameters, **values}
        try:
            return self._features(self._coursework._replace(parameters=parameters))
        except (TrialError, NotConnectedError):
            return None

    def _reads_hidden(self, node: str) -> bool:
        """Return True if a node changes with other parameters than numbers of the launch file.

        Its source may name them, or the node set them itself. A launch file may set a text of a
        number, or a list of numbers.
        """
        values: Dict[str, Any] = {}
        for name, default in self._coursework.names_in_source(self._node(node).command.name):
            value = changed(default, role_of(name, _roles(node)), is_far=False)
            for place in self._places(node, name):
                values[place] = value
        for name, own in self._own.items():
            if is_number(own) and name.startswith(self._node(node).global_name + "/"):
                values[name] = changed(own, self._role(name)[1], is_far=False)
        known = self._coursework.parameters
        values = {name: value for name, value in values.items() if name not in known}
        for name, value in known.items():
            other = changed_text_or_list(value, self._role(name)[1])
            if other != value:
                values[name] = other
        return bool(values) and node in self._effect(values)

    def _places(self, node: str, name: str) -> Sequence[str]:
        student = self._node(node)
        if name.startswith("~"):
            return [f"{student.global_name}/{name[1:]}"]
        return [name if name.startswith("/") else student.namespace + name]

    def _names_of(self, last: str) -> List[str]:
        """Return the global names that a program may read a parameter by."""
        places = {"/"}
        for node in (self._pair.generator, self._pair.process):
            places |= {node.namespace, node.global_name + "/"}
        return sorted(place + last for place in places)

    def _node(self, node: str) -> Any:
        return self._pair.generator if node == GENERATOR else self._pair.process

    def _changed(self, name: str, value: Any) -> Any:
        return changed(value, self._role(name)[1])

    def _role(self, name: str) -> Tuple[str, str]:
        """Return the node that a parameter belongs to, by its name, and its role."""
        owners = {
            GENERATOR: self._pair.generator.global_name,
            PROCESS: self._pair.process.global_name,
        }
        for node, owner in owners.items():
            if name.startswith(owner + "/"):
                return node, role_of(name.rpartition("/")[2], _roles(node))
        last = name.rpartition("/")[2]
        for node, parts in ((PROCESS, ("proc",)), (GENERATOR, ("gen", "sig", "sin"))):
            if any(part in last.lower() for part in parts):
                return node, role_of(last, _roles(node))
        if role_of(last, {"frequency": GENERATOR_ROLES["frequency"]}) == "frequency":
            return GENERATOR, "frequency"
        shift = role_of(last, {"phase_shift": PROCESS_ROLES["phase_shift"]})
        return (PROCESS, shift) if shift else ("", "")


def _roles(node: str) -> Dict[str, Tuple[str, ...]]:
    return GENERATOR_ROLES if node == GENERATOR else PROCESS_ROLES


def _is_distorted(features: TrialFeatures) -> bool:
    """Return True if the signal is a sine, but not the output."""
    process = features.process
    return process is not None and process.distortion > _DISTORTED


def _names_of_numbers(content: Any, name: str = "") -> Set[str]:
    """Return the last names of the numbers in a YAML file."""
    if isinstance(content, dict):
        return {one for key in content for one in _names_of_numbers(content[key], str(key))}
    return {name} if is_number(content) else set()
