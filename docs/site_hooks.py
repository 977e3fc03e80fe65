"""Parts of the site that stand elsewhere: the help of the commands, the cases, and a section of the README."""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the parts where a page asks for them. Called by MkDocs for every page."""
    for folder in (ROOT, ROOT / "docs"):
        if str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
    markdown = re.sub(r"<!-- readme: (.*) -->", lambda found: _section(found[1]), markdown)
    markdown = re.sub(r"<!-- help: ?([a-z]*) -->", lambda found: _help(found[1]), markdown)
    return markdown.replace("<!-- cases -->", _cases()) if "<!-- cases -->" in markdown else markdown


def _section(title: str) -> str:
    """Return a section of the README without its title and without what follows its list."""
    text = (ROOT / "README.md").read_text(encoding="utf-8").partition(f"## {title}\n")[2]
    return text.partition("\n## ")[0].strip().partition("\n\n")[0]


def _help(command: str) -> str:
    from tcontact.commands.cli import main

    os.environ["COLUMNS"] = "110"
    words = [command] if command else []
    with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.suppress(SystemExit):
        main([*words, "--help"])
    return f"```text\n{printed.getvalue().rstrip()}\n```"


def _cases() -> str:
    from site_docstrings import listed, plain

    from tcontact import cases

    parts = []
    for name in cases.names():
        found = cases.parameters(name)
        parts.append(f"## {name}\n\n{plain(cases.title(name))}\n")
        parts.append(f"{plain(cases.about(name))}\n\n{listed(cases.about_parameters(name), found)}\n")
        if found:
            parts.append("| parameter | default | type |\n|---|---|---|")
            rows = ((key, default, kind.replace("|", "\\|")) for key, (kind, default) in found.items())
            parts += [f"| `{key}` | `{default}` | {kind} |" for key, default, kind in rows]
            parts.append("")
        if cases.compares(name):
            parts.append(f"`--set compare=true`: {cases.compares(name)}\n")
        if cases.took(name):
            parts.append(f"With its defaults it {cases.took(name)}.\n")
    return "\n".join(parts)
