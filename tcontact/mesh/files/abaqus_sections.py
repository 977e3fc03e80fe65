"""Split Abaqus input files into sections: a keyword, its options and its data lines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from .content import MeshFileError

_UNKNOWN = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "INCLUDE", "SYSTEM"}
_MESH = {"NODE", "ELEMENT", "NSET", "ELSET", "SURFACE"}


@dataclass
class Section:
    """A keyword in capitals, its options by their names in capitals, the words of its data lines."""

    keyword: str
    options: dict[str, str]
    rows: list[list[str]]

    @property
    def name(self) -> str:
        """The name that the section gives to what it defines, "" without."""
        named = self.keyword in ("SURFACE", "PART", "INSTANCE")
        return self.options.get("NAME" if named else self.keyword, "")

    @property
    def words(self) -> list[str]:
        """All words of the data lines."""
        return [word for row in self.rows for word in row if word]


def read_sections(path: Path) -> list[Section]:
    """Return the sections of a file. Raises `MeshFileError` for keywords that make or move nodes and elements."""
    sections = list(_sections(path))
    for section in sections:
        if section.keyword in _UNKNOWN:
            reason = f"*{section.keyword} is not understood"
        elif section.keyword in _MESH and "INPUT" in section.options:
            reason = f"*{section.keyword} with INPUT={section.options['INPUT']} is not understood"
        elif section.keyword == "INSTANCE" and {"INSTANCE", "LIBRARY"} & section.options.keys():
            reason = "an *INSTANCE of another analysis is not understood"
        else:
            continue
        raise MeshFileError(f"{reason}; export the mesh with all nodes and elements written out in one file")
    return sections


def _split(line: str) -> list[str]:
    """Return the parts of a line between commas; those within quotation marks belong to a name."""
    if '"' not in line:
        return line.split(",")
    parts = [""]
    for number, text in enumerate(line.split('"')):
        if number % 2:
            parts[-1] += f'"{text}"'
        else:
            first, *others = text.split(",")
            parts[-1] += first
            parts += others
    return parts


def _sections(path: Path) -> Iterator[Section]:
    current: Section | None = None
    keyword_goes_on = False
    for whole in path.read_text(encoding="utf-8-sig", errors="replace").splitlines():
        line = whole.strip()
        if line.startswith("**") or not line:
            continue
        if line.startswith("*") or keyword_goes_on:
            words = [word.strip() for word in _split(line.lstrip("*"))]
            if not keyword_goes_on:
                if current is not None:
                    yield current
                current = Section(" ".join(words.pop(0).upper().split()), {}, [])
            for word in filter(None, words):
                option, _, value = word.partition("=")
                assert current is not None
                current.options[option.strip().upper()] = value.strip().replace('"', "")
            keyword_goes_on = line.endswith(",")
        elif current is not None:
            current.rows.append([word.strip().replace('"', "") for word in _split(line)])
    if current is not None:
        yield current
