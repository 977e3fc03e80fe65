"""Which bodies belong together because pairs or springs connect them: found once for all bodies of a scene."""

from __future__ import annotations

from collections.abc import Iterable


def connected(count: int, links: Iterable[Iterable[int]]) -> tuple[tuple[int, ...], ...]:
    """Return for each of `count` bodies the numbers of all that links connect to it, with itself, ascending.

    links: numbers of the bodies that each link joins. Bodies that are connected share one tuple. The time is that of
    one pass over bodies and links.
    """
    above = list(range(count))  # a body of the same group with a lower number; the lowest one of a group has its own

    def lowest(number: int) -> int:
        while above[number] != number:
            above[number] = above[above[number]]
            number = above[number]
        return number

    for link in links:
        ends = sorted({lowest(number) for number in link})
        for number in ends[1:]:
            above[number] = ends[0]
    members: dict[int, list[int]] = {}
    for number in range(count):
        members.setdefault(lowest(number), []).append(number)
    groups = {first: tuple(numbers) for first, numbers in members.items()}
    return tuple(groups[lowest(number)] for number in range(count))
