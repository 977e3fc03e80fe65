"""The table and the figure of a study for its page."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

from ...base.errors import InputError


def study_of(folder: Path) -> dict[str, Any]:
    """Return the rows of a study and its figure. Raises `InputError` for a study.json that cannot be read."""
    file = folder / "study.json"
    try:
        report = json.loads(file.read_text(encoding="utf-8"))
        rows = [dict(row) for row in report["rows"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        remedy = f"cannot be read ({error}); run the study again"
        raise InputError("DIR", str(file), remedy) from error
    head = list(dict.fromkeys(name for row in rows for name, value in row.items() if _plain(value)))
    picture = folder / "study.png"
    return {
        "title": f"study {report.get('case') or folder.name}",
        "head": [name.replace("_", " ") for name in head],
        "rows": [[_text(row.get(name)) for name in head] for row in rows],
        "picture": base64.b64encode(picture.read_bytes()).decode("ascii") if picture.is_file() else "",
    }


def _plain(value: Any) -> bool:
    return isinstance(value, (str, int, float, bool)) or value is None


def _text(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: ""}[value]
    return f"{value:.4g}" if isinstance(value, float) else str(value) if _plain(value) else ""
