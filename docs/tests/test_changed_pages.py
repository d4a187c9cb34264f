"""A page is typed again when it, or what its commands name, has changed."""

from typing import List

import pytest
from changed_pages import dependencies, pages_to_type
from pages import WORKSPACE, texts_of_pages

PAGES = {
    "docs/talk.md": "```sh\nrosrun basic_comms talker.py\n```\n",
    "docs/plot.md": "topic_scope\n```console\n$ rosrun topic_scope plot_bag.py\n```\n",
    "docs/pump.md": "```console\n$ docs/examples/pump.py\n```\n",
    "docs/text.md": "basic_comms, without a command\n",
}
DEPENDS_ON = {"basic_comms": {"nodekit"}, "topic_scope": {"msgs"}, "msgs": {"std_msgs"}}


@pytest.mark.parametrize(
    "changed, pages",
    [
        ([], []),
        (["docs/text.md"], ["text"]),
        (["src/basic_comms/scripts/talker.py"], ["talk"]),
        (["src/nodekit/src/nodekit/node/ros_node.py"], ["talk"]),
        (["src/msgs/msg/A.msg", "docs/talk.md"], ["talk", "plot"]),
        (["docs/examples/pump.py"], ["pump"]),
        (["docs/examples/other.py", "README.md", "src/other/a.py", "ci/lint/language.py"], []),
        (["docs/tests/job.py"], ["talk", "plot", "pump", "text"]),
        (["ci/setup/build.bash"], ["talk", "plot", "pump", "text"]),
    ],
)
def test_change_selects_the_pages_that_name_it(changed: List[str], pages: List[str]) -> None:
    assert pages_to_type(PAGES, changed, DEPENDS_ON) == {f"docs/{page}.md" for page in pages}


def test_dependencies_are_read_from_the_manifests() -> None:
    found = dependencies(WORKSPACE)
    assert "nodekit" in found["basic_comms"]
    assert "basic_comms" in found["first_order_sys_sim"]


def test_toolkit_is_behind_most_pages_and_a_course_package_behind_few() -> None:
    pages = texts_of_pages()

    def count(path: str) -> int:
        return len(pages_to_type(pages, [path], dependencies(WORKSPACE)))

    assert 0 < count("src/executors_demo/package.xml") < 10 < count("src/nodekit/package.xml")
