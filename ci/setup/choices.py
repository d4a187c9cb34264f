"""Print what --only of ci/bench, ci/soak or ci/two-hosts can name: to import the list takes ROS.

Called with the file that has the list.
"""

import ast
import pathlib
import sys

for node in ast.walk(ast.parse(pathlib.Path(sys.argv[1]).read_text("utf-8"))):
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("Measurement", "Run"):
        name, text = (ast.literal_eval(argument) for argument in node.args[:2])
        is_extra = any(keyword.arg == "is_extra" for keyword in node.keywords)
        print(f"  {name:14} {text}{', with --all' if is_extra else ''}")
