"""Sphinx configuration of the pages: ``./ci/exec python3 -m sphinx -W docs docs/_build/html``."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

DOCS = Path(__file__).resolve().parent
PACKAGE = DOCS.parent / "src" / "basic_comms"

project = "basic_comms"
author = copyright = "the basic_comms maintainers"
version = release = ElementTree.parse(PACKAGE / "package.xml").findtext("version", "")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.graphviz",
    "docs._ext.controller_plots",
    "docs._ext.parameter_tables",
    "docs._ext.course_tables",
    "docs._ext.launch_tables",
    "docs._ext.lifecycle_graphs",
    "docs._ext.plant_plots",
    "docs._ext.state_graphs",
    "docs._ext.drive_plots",
    "docs._ext.waveform_plots",
]
exclude_patterns = ["_build", "_generated", "tests"]
myst_enable_extensions = ["deflist"]
myst_heading_anchors = 3
launch_tables_folder = str(PACKAGE / "launch")

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
graphviz_output_format = "svg"

html_theme = "sphinx_rtd_theme"
html_theme_options = {"navigation_depth": 2}
html_title = "basic_comms"
html_static_path = ["_static"]
html_css_files = ["basic_comms.css"]
html_show_sphinx = False
