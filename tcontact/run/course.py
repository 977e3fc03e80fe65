"""The progress of a run between two steps, and which of its frames are still to come."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Course:
    """The progress of a run between two steps, which a checkpoint holds besides bodies and history.

    time [s]: of the next row; before [s]: the step that ended there; due [s]: times of the frames, ascending; passed:
    how many of them have their frame (checkpoints of earlier versions hold the other times alone); frames: number of
    frames; first_dt [s]: first step; wall [s]: time spent on steps so far.
    """

    begun: bool = False
    time: float = 0.0
    before: float = 0.0
    row: int = 0
    due: list[float] = field(default_factory=list)
    passed: int = 0
    frames: int = 0
    first_dt: float = 0.0
    wall: float = 0.0

    @property
    def left(self) -> int:
        """Number of the times that have no frame yet."""
        return len(self.due) - self.passed

    @property
    def next_frame(self) -> float:
        """Time [s] of the next frame, infinite without any."""
        return self.due[self.passed] if self.left else float("inf")

    def pass_frames(self, time: float, step: float) -> None:
        """Let the frame at a time [s] stand for all that were due up to half a step [s] after it."""
        while self.left and not self.due[self.passed] - 0.5 * step > time:
            self.passed += 1
