"""Reads a report's page, and makes pages of trials that are a little other."""

import html
import json
import re
import shutil

from worm_analysis.report import write_report

PAPER = ["fig-1c", "fig-2", "fig-1d", "fig-1e", "fig-3", "fig-7a"]
"""As they come: the whole of a short trial against time is among what it begins with."""


def report_of(directory):
    return write_report(directory).read_text(encoding="utf-8")


def figure(page, key):
    """Return one figure's HTML."""
    found = re.findall(rf'<figure id="{key}".*?</figure>', page, flags=re.DOTALL)
    assert len(found) == 1, f"{key}: {len(found)} figures"
    return found[0]


def words(markup):
    """Return what a reader sees of some HTML."""
    return " ".join(html.unescape(re.sub(r"<[^>]*>", "", markup)).split())


def rows(panel):
    """Return the words of each cell of each row of a figure's table."""
    return [
        [words(cell) for cell in re.findall(r"<t[hd]\b.*?</t[hd]>", row)]
        for row in re.findall(r"<tr.*?</tr>", panel)[1:]
    ]


def changed_summary(whole, directory, change):
    shutil.copytree(whole, directory)
    path = directory / "summary.json"
    summary = json.loads(path.read_text(encoding="utf-8"))
    change(summary)
    path.write_text(json.dumps(summary), encoding="utf-8")
    return directory
