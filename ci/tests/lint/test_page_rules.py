"""Tests of the import rules of the page's scripts."""

from typing import Dict, List

import pytest

from ci.lint import page_rules

FINE = {
    "base/dom.js": "/** Finds elements. */\nexport const byId = 1;\n",
    "state/state.js": 'import { byId } from "../base/dom.js";\nexport const state = byId;\n',
    "main.js": 'import { state } from "./state/state.js";\nstate();\n',
    "start.js": "{ /* no module */ }\n",
}


def found(changes: Dict[str, str]) -> List[str]:
    return list(page_rules.breaches({**FINE, **changes}))


def test_imports_from_the_rooms_before_are_fine() -> None:
    assert found({}) == []


@pytest.mark.parametrize(
    "text",
    [
        'import { state } from "../state/state.js";\nstate();\n',
        'import {\n  state,\n} from "../state/state.js";\nstate();\n',
        'import "../state/state.js";\n',
        'export { state } from "../state/state.js";\nstate();\n',
        'const later = () => import("../state/state.js");\n',
    ],
)
def test_an_upward_import_is_found_in_every_form(text: str) -> None:
    (sentence,) = found({"base/keys.js": text})
    assert sentence.startswith("base/keys.js:")
    assert sentence.endswith("base may not import state/state.js")


def test_a_module_of_a_room_does_not_import_the_entry() -> None:
    told = found({"page/tools.js": 'import "../main.js";\n'})
    assert told == ["page/tools.js:1: page may not import main.js"]


def test_import_in_a_comment_is_ignored() -> None:
    assert found({"base/keys.js": '// import "../state/state.js";\n'}) == []
    assert found({"base/keys.js": '/** @param {import("../state/state.js").State} */\n'}) == []


def test_a_circle_is_found() -> None:
    one = 'import { b } from "./b.js";\nexport const a = b;\n'
    two = 'import { a } from "./a.js";\nexport const b = a;\n'
    told = found({"plot/a.js": one, "plot/b.js": two})
    assert told == ["import cycle: plot/a.js -> plot/b.js -> plot/a.js"]


def test_a_file_that_does_not_exist_is_found() -> None:
    told = found({"plot/a.js": 'import "./b.js";\n', "plot/c.js": 'import "../../start.js";\n'})
    assert told == [
        "plot/a.js:1: there is no module ./b.js",
        "plot/c.js:1: there is no module ../../start.js",
    ]
    told = found({"plot/a.js": '/** @param {import("./b.js").B} b */\n'})
    assert told == ["plot/a.js: a comment names ./b.js, which does not exist"]


def test_a_script_without_a_room_is_found() -> None:
    assert found({"lost.js": "", "attic/old.js": ""}) == [
        "attic/old.js: it is in no room",
        "lost.js: it is in no room",
    ]


def test_an_import_that_is_not_used_is_found() -> None:
    text = 'import { byId as find, make } from "../base/dom.js";\nfind(1);\n'
    told = found({"base/dom.js": "export const [byId, make] = [];", "plot/a.js": text})
    assert told == ["plot/a.js:1: make is imported and not used"]


def test_a_script_that_is_too_long_is_found() -> None:
    assert found({"base/keys.js": "\n" * 400}) == []
    assert found({"base/keys.js": "\n" * 401}) == ["base/keys.js: longer than 400 lines"]
