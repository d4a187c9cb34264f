"""HTML pages about a class: verdicts, causes, and links to the files of each submission."""

from collections import Counter
from html import escape
from typing import Dict, List, Sequence
from urllib.parse import quote

from pid_control.verdicts.judgement import FAILED, NOT_JUDGED, PASSED

_STYLE = (
    "body{font:15px sans-serif;margin:2em;max-width:70em}"
    "table{border-collapse:collapse;width:100%}"
    "td,th{border-bottom:1px solid #ccc;padding:.4em .6em;text-align:left;vertical-align:top}"
    ".passed{color:#00603a}.failed{color:#b00020}.not-judged{color:#775500}"
)


def as_html(rows: Sequence[Dict[str, str]], subject: str, files: Dict[str, List[str]]) -> str:
    """Return the HTML page.

    :param rows: rows of the CSV file
    :param subject: heading of the column with the names
    :param files: files of each name, in the page's folder
    """
    verdicts = Counter(row["verdict"] for row in rows)
    counts = ", ".join(f"{verdicts[name]} {name}" for name in (PASSED, FAILED, NOT_JUDGED))
    flaws = Counter(flaw for row in rows for flaw in row["flaws"].split(", ") if flaw)
    lines = [
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>Class</title>',
        f"<style>{_STYLE}</style></head><body><h1>{len(rows)} {subject}s</h1><p>{counts}</p>",
    ]
    if flaws:
        counted = ", ".join(f"{escape(flaw)} ({count})" for flaw, count in flaws.most_common())
        lines.append(f"<p>Flaws: {counted}</p>")
    has_students = any("student" in row for row in rows)
    head = "<th>student</th>" if has_students else ""
    lines.append(f"<table><tr>{head}<th>{subject}</th><th>verdict</th><th>why</th><th></th></tr>")
    for row in rows:
        verdict = row["verdict"]
        links = " ".join(
            f'<a href="{quote(name)}">{escape(name.rpartition(".")[2])}</a>'
            for name in files.get(row[subject], [])
        )
        student = f"<td>{escape(row['student'])}</td>" if has_students else ""
        lines.append(
            f"<tr>{student}<td>{escape(row[subject])}</td>"
            f'<td class="{escape(verdict.replace(" ", "-"))}">{escape(verdict)}</td>'
            f"<td>{escape(row['why'])}</td><td>{links}</td></tr>"
        )
    return "\n".join([*lines, "</table></body></html>"]) + "\n"


def as_page_of_student(
    row: Dict[str, str], subject: str, text: str, pictures: Sequence[str]
) -> str:
    """Return the HTML page for a student.

    :param row: row of the CSV file
    :param subject: heading of the column with the names
    :param text: text of the judgement, if any
    :param pictures: names of the pictures in the page's folder
    """
    title = " ".join(filter(None, [row.get("student"), row[subject]]))
    verdict = row["verdict"]
    lines = [
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head>",
        f"<body><h1>{escape(title)}</h1>",
        f'<p class="{escape(verdict.replace(" ", "-"))}">{escape(verdict)}'
        f"{': ' if row['why'] else ''}{escape(row['why'])}</p>",
        *(f'<p><img src="{quote(name)}" alt="all scenarios"></p>' for name in pictures),
        f"<pre>{escape(text)}</pre></body></html>",
    ]
    return "\n".join(lines) + "\n"
