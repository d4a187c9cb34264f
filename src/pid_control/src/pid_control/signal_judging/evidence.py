"""Evidence about a signal generator and process node: results of trials, effects of parameters."""

import types
from typing import Any, Dict, List, Mapping, NamedTuple, Optional, Sequence, Set, Tuple

from pid_control.signal_judging.channels import Channel
from pid_control.signal_judging.features import ProcessFeatures, SignalFeatures

#: Roles of parameters that every signal and output has.
_ALWAYS = ("amplitude", "frequency", "gain", "phase_shift")
GENERATOR, PROCESS = "signal generator", "process node"
#: Distortion from which a signal is not a sine, and its record is repeated.
DISTORTED = 0.05


class FailedTrial(NamedTuple):
    """Trial that failed: a node ended, or the nodes were not connected.

    :ivar flaw: how it failed
    :ivar node: the node
    :ivar words: last line of its output
    """

    flaw: str
    node: str
    words: str = ""


class TrialFeatures(NamedTuple):
    """Features of both nodes in one trial.

    :ivar signal: of the generator
    :ivar process: of the process node; None if its output, or its input, is not a sine
    """

    signal: SignalFeatures
    process: Optional[ProcessFeatures]

    @property
    def distortion(self) -> float:
        """Distortion of the signal, or of the output if that is larger; at most 1."""
        sine, process = self.signal.sine, self.process
        if sine is None or sine.distortion > DISTORTED:
            return 1.0 if sine is None else min(1.0, sine.distortion)
        return 1.0 if process is None else min(1.0, process.distortion)


class BaselineTrial(NamedTuple):
    """Trial of the unchanged coursework, to which the other trials are compared.

    :ivar features: features of both nodes
    :ivar signal: the generator's signal
    :ivar output: the process node's output
    :ivar constants: constant fields of the signal's messages, by name
    :ivar own_parameters: parameters that the nodes themselves have set, by global name
    """

    features: TrialFeatures
    signal: Channel
    output: Channel
    constants: Mapping[str, float]
    own_parameters: Mapping[str, Any] = types.MappingProxyType({})


class RestartTrial(NamedTuple):
    """Trial in which the generator is stopped and started again.

    :ivar oscillates: whether the output kept oscillating without an input
    :ivar after: features of the process node after the restart; None without any
    :ivar signal: the generator's signal, from before the stop to the end
    :ivar output: the process node's output
    """

    oscillates: bool
    after: Optional[ProcessFeatures]
    signal: Channel
    output: Channel


class ParameterEffect(NamedTuple):
    """A parameter, and the effect of a change of it.

    :ivar name: global name
    :ivar value: value in the launch file
    :ivar role: role of the parameter; empty if unknown
    :ivar of: the nodes that changed with it
    :ivar other_names: names under which a change had an effect, if this name had none
    :ivar is_mentioned: whether a source mentions the name
    :ivar is_predicted: whether the effect is the one expected from its role, in kind and size
    """

    name: str
    value: float
    role: str
    of: Set[str]
    other_names: Sequence[str] = ()
    is_mentioned: bool = True
    is_predicted: bool = False


class ParameterResults(NamedTuple):
    """Effects of the parameters.

    :ivar tried: parameters of the launch file
    :ivar hidden: nodes that changed with parameters that only their sources name, or that are not
        numbers
    :ivar unused_files: YAML files of numbers that do not reach the nodes, and why not
    :ivar has_files: whether there are YAML files of numbers
    """

    tried: Sequence[ParameterEffect]
    hidden: Set[str]
    unused_files: Mapping[str, str]
    has_files: bool

    def read_by(self, node: str) -> int:
        """Return the number of parameters that change a node, at least 1 if hidden ones do."""
        return max(sum(node in one.of for one in self.tried), int(node in self.hidden))

    def unread(self) -> List[ParameterEffect]:
        """Return the parameters that are certainly not used.

        A parameter without effect that a source mentions may be used in other cases, unless it is
        the only one for a property that every signal has.
        """
        return [
            one
            for one in self.tried
            if not one.of
            and (
                one.other_names
                or not one.is_mentioned
                or (one.role in _ALWAYS and not self._is_changed(one.role))
            )
        ]

    def _is_changed(self, role: str) -> bool:
        return any(one.role == role and one.of for one in self.tried)

    def value_of(self, node: str, role: str) -> Optional[Tuple[str, float]]:
        """Return name and value of the only parameter with the effect expected from a role.

        A parameter with another effect has another unit or meaning.
        """
        found = [
            one for one in self.tried if one.role == role and node in one.of and one.is_predicted
        ]
        return (found[0].name, found[0].value) if len(found) == 1 else None


class CourseworkEvidence:
    """Evidence about a coursework from all its trials.

    :ivar missing: why no launch file starts both nodes; empty if one does
    :ivar baseline: trial of the unchanged coursework
    :ivar restart: the generator stopped and started again
    :ivar parameters: effects of the parameters
    :ivar outside: topics that leave the namespace of their nodes
    :ivar broken: trials that a node ended, by scenario
    """

    def __init__(self) -> None:
        self.missing = ""
        self.baseline: Optional[BaselineTrial] = None
        self.restart: Optional[RestartTrial] = None
        self.parameters: Optional[ParameterResults] = None
        self.outside: Optional[List[str]] = None
        self.broken: Dict[str, FailedTrial] = {}
