"""Session that judges a student's signal generator and process node: its trials in turn."""

import math
import time
from typing import Any, Callable, List, Mapping, Optional, Sequence, Tuple

from pid_control.programs.private_master import PrivateMaster
from pid_control.runner.judging_errors import BusyMachineError, JudgingError, TimeLimitExceeded
from pid_control.signal_judging.channels import (
    AmbiguousChannelsError,
    Channel,
    oscillates,
    signal_of,
)
from pid_control.signal_judging.clock_pauses import moved_in_pauses
from pid_control.signal_judging.evidence import (
    DISTORTED,
    GENERATOR,
    PROCESS,
    BaselineTrial,
    CourseworkEvidence,
    FailedTrial,
    RestartTrial,
    TrialFeatures,
)
from pid_control.signal_judging.features import (
    ProcessFeatures,
    is_sine_like,
    process_features,
    signal_features,
)
from pid_control.signal_judging.sine_fit import is_constant
from pid_control.signal_runner.coursework import Coursework
from pid_control.signal_runner.parameter_trials import ParameterTrials
from pid_control.signal_runner.node_pair import NodePair
from pid_control.signal_runner.signal_bench import SignalBench
from pid_control.signal_runner.trial import STEP_S, NotConnectedError, Trial, TrialError

#: Times by the clock [s]: before a record begins, shortest and longest record, shortest stop.
_SETTLE_S, _SHORTEST_S, _LONGEST_S, _STOPPED_S = 1.0, 5.0, 30.0, 2.0
#: Time after the stop in which messages may still arrive [s].
_AFTER_STOP_S = 0.5
#: Largest delay of the judge in a trial by the machine's clock [s].
_MOST_LATE_S = 0.1
#: Share of the clock's rate from which it may limit a loop; factor to the next finer step of the
#: clock; and the finest step [s].
_NEAR, _FINER, _FINEST_S = 0.8, 5.0, 0.0004
#: Periods of a record.
_PERIODS = 2.2
#: Namespace for the trial that checks names.
_GROUP = "/judged_group"
#: Most repetitions of what a busy machine may spoil.
_MOST_REPEATED = 2
#: Messages between two pauses of the clock: irregular, as the values may be periodic.
_BETWEEN_PAUSES = (2.0, 3.0, 2.0, 4.0, 3.0, 2.0, 4.0, 3.0)
_MACHINE_CLOCK = (
    "it uses the machine's clock (time.time(), time.sleep()), not ROS's"
    " (rospy.get_time(), rospy.Rate): judge it with --real-time"
)


class SignalSession:
    """One judgement of a coursework; the time limit starts when the session is created.

    :param coursework: the coursework
    :param scenarios: names of the scenarios to run
    :param real_time: True for the machine's clock, False for a simulated one
    :param time_limit: time limit [s]
    :param given: names of the signal's and of the output's channel, ``TOPIC/FIELD``, if given
    :param master: the private master
    :param bench: the bench on that master

    :ivar evidence: evidence of the trials
    :ivar notes: notes on choices
    """

    def __init__(
        self,
        coursework: Coursework,
        scenarios: Sequence[str],
        real_time: bool,
        time_limit: float,
        given: Mapping[str, str],
        master: PrivateMaster,
        bench: SignalBench,
    ) -> None:
        self._master, self._bench = master, bench
        self._coursework, self._scenarios = coursework, scenarios
        self._real_time, self._given = real_time, given
        self._deadline, self._time_limit = time.monotonic() + time_limit, time_limit
        self.evidence = CourseworkEvidence()
        self.evidence.missing = coursework.missing
        self.notes: List[str] = []
        self._pair: Optional[NodePair] = None
        #: Step of the clock [s].
        self._step = STEP_S

    def run(self) -> str:
        """Run all trials.

        :returns: why not all of them were run, or an empty text
        :raises JudgingError: if the coursework cannot be judged
        """
        try:
            return self._run_all()
        except TimeLimitExceeded:
            return f"{self._time_limit:g} s are over"

    def _run_all(self) -> str:
        if set(self._scenarios) == {"launch"}:
            return ""
        if not self._guarded("signal", self._run_baseline):
            return ""
        baseline = self.evidence.baseline
        assert baseline is not None and self._pair is not None
        if set(self._scenarios) & {"parameters", "yaml"} and baseline.features.signal.sine:
            trials = ParameterTrials(self._coursework, self._pair, baseline, self._features)
            self._guarded("parameters", lambda: self._put_parameters(trials))
            self.notes += trials.notes
        if "namespace" in self._scenarios:
            self._guarded("namespace", self._run_in_group)
        return ""

    def _put_parameters(self, trials: ParameterTrials) -> None:
        self.evidence.parameters = trials.run()

    def _guarded(self, scenario: str, run: Callable[[], None]) -> bool:
        """Run a scenario; return False if a node ended it."""
        try:
            run()
            return True
        except TrialError as error:
            self.evidence.broken[scenario] = FailedTrial(error.flaw, error.node, error.words)
        except NotConnectedError as error:
            self.evidence.broken[scenario] = FailedTrial("not connected", "", str(error))
        return False

    def _trial(
        self,
        parameters: Optional[Mapping[str, Any]] = None,
        group: str = "",
    ) -> Trial:
        nodes = self._coursework.nodes
        if self._pair is not None:  # the process node first: the generator is to be restarted
            nodes = [self._pair.process, self._pair.generator]
        return Trial(
            self._bench,
            self._master,
            nodes,
            self._coursework.parameters if parameters is None else parameters,
            self._deadline,
            not self._real_time,
            group,
            self._step,
        )

    def _run_baseline(self) -> None:
        nodes = self._coursework.nodes
        with self._trial() as trial:
            trial.start()
            self._pair = pair = trial.find_pair()
            is_as_started = list(nodes) == [pair.process, pair.generator]
            if is_as_started:
                self._record_baseline(trial, pair)
        self.notes.append(
            f"{pair.generator.program} is the signal generator, {pair.process.program} the"
            f" process node"
        )
        if not is_as_started:
            self._repeat_baseline(pair)
        while not self._real_time and self._is_too_fast():
            self._step /= _FINER
            self._repeat_baseline(pair)
        baseline = self.evidence.baseline
        assert baseline is not None
        self.notes.append(f"signal: {baseline.signal.name}; output: {baseline.output.name}")
        if not self._real_time and oscillates(baseline.output):
            self._repeat_if_distorted(baseline, pair)

    def _repeat_if_distorted(self, first: BaselineTrial, pair: NodePair) -> None:
        """Repeat a record that a busy machine may have distorted; a flaw distorts every record."""
        baseline, repeated = first, 0
        while baseline.features.distortion > DISTORTED and repeated < _MOST_REPEATED:
            baseline, repeated = self._repeat_baseline(pair), repeated + 1
        if repeated and baseline.features.distortion <= DISTORTED:
            before = first.features.distortion
            self.notes.append(
                f"a record was repeated, because its distortion was {before:.2f}: the machine was"
                " busy, or the nodes do not always behave the same"
            )

    def _repeat_baseline(self, pair: NodePair) -> BaselineTrial:
        self.evidence.baseline = self.evidence.restart = None
        self.evidence.broken.clear()
        with self._trial() as trial:
            trial.start()
            return self._record_baseline(trial, pair)

    def _is_too_fast(self) -> bool:
        """Return True if a loop may be faster than the steps of the clock, which slow it down.

        :raises JudgingError: if even the finest step slows it down
        """
        baseline = self.evidence.baseline
        assert baseline is not None
        rates = [one.rate() or 0.0 for one in (baseline.signal, baseline.output)]
        if max(rates) < _NEAR / self._step:
            return False
        if self._step / _FINER < _FINEST_S:
            raise JudgingError(
                f"unknown signal: more than {max(rates):.0f} messages per second; lower the rate,"
                " or judge it with --real-time"
            )
        return True

    def _record_baseline(self, trial: Trial, pair: NodePair) -> BaselineTrial:
        trial.connect(pair)
        trial.run(_SETTLE_S)
        begin = trial.now
        trial.run(_SETTLE_S)
        publishes = trial.publishes_while_paused()  # the machine's clock continues meanwhile
        self._run_periods(trial, pair, begin)
        if publishes or trial.publishes_while_paused():
            raise JudgingError(_MACHINE_CLOCK)
        self._check_heard()
        signal, output = self._channels(pair, begin)
        end = trial.now
        features = self._features_of(signal, output)
        constants = self._constants(signal, begin)
        self.evidence.baseline = baseline = BaselineTrial(
            features, signal, output, constants, trial.own_parameters()
        )
        rate = signal.rate()
        if rate and not self._real_time:
            self._check_clock(trial, pair, rate)
        if "restart" in self._scenarios and features.signal.sine is not None:
            self._guarded("restart", lambda: self._run_restart(trial, pair, begin, end))
        self._check_lateness(trial)
        return baseline

    def _check_heard(self) -> None:
        """Check that this process is connected to all topics.

        :raises JudgingError: if it is not: it has other definitions of their types
        """
        unheard = self._bench.unheard()
        if unheard:
            names = ", ".join(unheard)
            raise JudgingError(f"{names}: another definition of its type than the judge's")

    def _run_periods(self, trial: Trial, pair: NodePair, begin: float) -> None:
        """Run until some periods of the signal are recorded, within bounds."""
        trial.run(begin + _SHORTEST_S - trial.now)
        while trial.now - begin < _LONGEST_S:
            signal, _ = self._channels(pair, begin)
            sine = signal_features(signal).sine
            if sine is not None and sine.periods >= _PERIODS:
                return
            left = _LONGEST_S - (trial.now - begin)
            wanted = _SHORTEST_S
            if sine is not None and sine.periods > 0.0:
                wanted = (trial.now - begin) * (_PERIODS / sine.periods - 1.0) + 0.2
            trial.run(min(left, max(wanted, 0.5)))

    def _run_restart(self, trial: Trial, pair: NodePair, begin: float, end: float) -> None:
        trial.stop_node(pair.generator)
        stopped = trial.now
        assert self.evidence.baseline is not None
        sine = self.evidence.baseline.features.signal.sine
        assert sine is not None
        period = 2.0 * math.pi / sine.frequency
        trial.run(_AFTER_STOP_S + min(max(period, _STOPPED_S), _LONGEST_S))
        since = stopped + _AFTER_STOP_S
        _, silent = self._channels(pair, since)
        goes_on = is_sine_like(silent, sine.frequency, since, trial.now)
        trial.run_past(self.evidence.baseline.output.topic)
        trial.start_node(pair.generator)
        trial.connect_again(pair)
        trial.run(_SETTLE_S)
        again = trial.now
        trial.run(end - begin)
        _, output = self._channels(pair, again)
        signal, _ = self._channels(pair, again)
        process = self._features_of(signal, output).process
        whole = self._channels(pair, begin)
        self.evidence.restart = RestartTrial(goes_on, process, whole[0], whole[1])

    def _features(self, coursework: Coursework) -> TrialFeatures:
        """Return the features of the coursework with other parameters.

        :raises TrialError: if a node fails
        """
        pair = self._pair
        assert pair is not None
        nodes = {node.global_name: node for node in coursework.nodes}
        self._pair = pair._replace(
            generator=nodes.get(pair.generator.global_name, pair.generator),
            process=nodes.get(pair.process.global_name, pair.process),
        )
        try:
            with self._trial(coursework.parameters) as trial:
                trial.start()
                trial.connect(self._pair)
                trial.run(_SETTLE_S)
                begin = trial.now
                self._run_periods(trial, self._pair, begin)
                signal, output = self._channels(self._pair, begin)
                self._check_lateness(trial)
                return self._features_of(signal, output)
        finally:
            self._pair = pair

    def _run_in_group(self) -> None:
        pair = self._pair
        assert pair is not None
        with self._trial(group=_GROUP) as trial:
            trial.start()
            topics = trial.topics([pair.process, pair.generator])
        self.evidence.outside = sorted(
            topic for topic in topics if not topic.startswith(_GROUP + "/")
        )

    def _check_clock(self, trial: Trial, pair: NodePair, rate: float) -> None:
        """Check in pauses of a simulated clock that both nodes use it.

        :param trial: the trial
        :param pair: both nodes
        :param rate: rate of the signal's messages [Hz]
        :raises JudgingError: if one uses the machine's clock
        :raises BusyMachineError: if that remains uncertain
        """
        durations = [min(one / rate, one) for one in _BETWEEN_PAUSES]
        for _ in range(1 + _MOST_REPEATED):
            begin = trial.now
            pauses = trial.run_with_pauses(durations)
            answers = [moved_in_pauses(one, pauses) for one in self._channels(pair, begin)]
            if True in answers:
                raise JudgingError(_MACHINE_CLOCK)
            if None not in answers:
                return
        raise BusyMachineError("this machine is too busy to see which clock the nodes use")

    def _check_lateness(self, trial: Trial) -> None:
        if trial.latest > _MOST_LATE_S:
            raise BusyMachineError(
                f"this machine is too busy: the judge itself was {trial.latest:.3f} s late"
            )

    def _channels(self, pair: NodePair, begin: float) -> Tuple[Channel, Channel]:
        """Return the signal and the output from a time on.

        :raises JudgingError: if they are ambiguous
        """
        signal = self._channel(GENERATOR, [*pair.inputs, *pair.others], begin)
        return signal, self._channel(PROCESS, list(pair.outputs), begin)

    def _channel(self, node: str, topics: Sequence[str], begin: float) -> Channel:
        channels = [
            channel.between(begin) for topic in topics for channel in self._bench.channels(topic)
        ]
        given = self._given.get(node)
        if given is not None:
            for channel in channels:
                if given.strip("/") in (channel.name.strip("/"), channel.topic.strip("/")):
                    return channel
            names = ", ".join(channel.name for channel in channels) or "none"
            raise JudgingError(f"{given}: not found; the {node} has: {names}")
        before = self.evidence.baseline
        if before is not None:
            chosen = before.signal if node == GENERATOR else before.output
            for channel in channels:
                if (channel.topic, channel.field) == (chosen.topic, chosen.field):
                    return channel
            return Channel(chosen.topic, chosen.field, [], [])
        try:
            found = signal_of(channels)
        except AmbiguousChannelsError as error:
            option = "--signal" if node == GENERATOR else "--proc-signal"
            raise JudgingError(
                f"which is the signal of the {node}? {option} TOPIC/FIELD, of {error}"
            ) from None
        if found is not None:
            return found
        if not channels:
            return Channel(topics[0], "", [], [])
        return channels[0] if len(channels) == 1 else channels[0]._replace(field="")

    def _features_of(self, signal: Channel, output: Channel) -> TrialFeatures:
        found = signal_features(signal)
        process: Optional[ProcessFeatures] = None
        if found.sine is not None and found.sine.distortion <= DISTORTED:
            process = process_features(output, signal.times, found.sine)
        return TrialFeatures(found, process)

    def _constants(self, signal: Channel, begin: float) -> Mapping[str, float]:
        channels = [one.between(begin) for one in self._bench.channels(signal.topic)]
        return {
            one.field: one.values[0] for one in channels if one.values and is_constant(one.values)
        }
