"""Texts that curves and pages show as they are, whatever the names in them: of users, their files and folders."""

from __future__ import annotations


def encodable(text: str) -> str:
    """Return a text with a question mark for each character that has no encoding: a byte of a file name, mostly."""
    return text.encode("utf-8", "replace").decode("utf-8")


def plain(text: str) -> str:
    """Return what matplotlib draws as this text: no `$` begins a formula, no `_` hides a curve from a legend."""
    escaped = encodable(text).replace("$", r"\$")
    return f" {escaped}" if escaped.startswith("_") else escaped
