"""Choice of the signal generator and the process node among nodes, by their topics."""

from typing import List, Mapping, NamedTuple, Optional, Sequence, Tuple

from pid_control.programs.node_queries import NodeTopics
from pid_control.signal_runner.coursework import StudentNode


class NodePair(NamedTuple):
    """The two nodes, and their topics.

    :ivar generator: the signal generator
    :ivar process: the process node
    :ivar inputs: type of each topic from the generator to the process node
    :ivar outputs: type of each topic that only the process node publishes
    :ivar others: type of each topic that only the generator publishes
    """

    generator: StudentNode
    process: StudentNode
    inputs: Mapping[str, str]
    outputs: Mapping[str, str]
    others: Mapping[str, str]


def choose_pair(
    nodes: Sequence[StudentNode], found: Mapping[str, NodeTopics]
) -> Optional[NodePair]:
    """Return two nodes: one subscribes to the other's topic, and publishes another."""
    pairs: List[Tuple[int, NodePair]] = []
    for process in nodes:
        for generator in nodes:
            if generator is process or not {process.global_name, generator.global_name} <= set(
                found
            ):
                continue
            theirs, own = found[generator.global_name], found[process.global_name]
            inputs = {
                topic: type_
                for topic, type_ in theirs.published.items()
                if own.subscribed.get(topic) in (type_, "*")
            }
            outputs = {t: type_ for t, type_ in own.published.items() if t not in theirs.published}
            if inputs and outputs:
                others = {t: type_ for t, type_ in theirs.published.items() if t not in inputs}
                likely = ("proc" in process.name + process.program) * 2
                likely += process.namespace == generator.namespace
                pairs.append((likely, NodePair(generator, process, inputs, outputs, others)))
    return max(pairs, key=lambda one: one[0])[1] if pairs else None


def describe_topics(nodes: Sequence[StudentNode], found: Mapping[str, NodeTopics]) -> str:
    """Return the topics of each node as text."""
    parts = []
    for node in nodes:
        topics = found.get(node.global_name)
        if topics is None:
            parts.append(f"{node.program} does not answer")
            continue
        published = ", ".join(
            f"{name} ({type_})" for name, type_ in sorted(topics.published.items())
        )
        subscribed = ", ".join(
            f"{name} ({type_})" for name, type_ in sorted(topics.subscribed.items())
        )
        parts.append(
            f"{node.program} publishes {published or 'nothing'} and subscribes to"
            f" {subscribed or 'nothing'}"
        )
    return "; ".join(parts)
