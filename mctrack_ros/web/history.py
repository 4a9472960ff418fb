"""Steps that are taken back and made again."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

State = TypeVar('State')


class History(Generic[State]):
    """
    States in the order in which they came, one of them the present.

    Parameters
    ----------
    first : State
        The state before any step; states are never changed in place.

    """

    def __init__(self, first: State) -> None:
        self._states, self._at = [first], 0

    @property
    def present(self) -> State:
        """The state now."""
        return self._states[self._at]

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to take back."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether a step was taken back that can be made again."""
        return self._at < len(self._states) - 1

    def step(self, state: State) -> None:
        """Make a step; those that were taken back are forgotten."""
        self._states = [*self._states[: self._at + 1], state]
        self._at += 1

    def undo(self) -> None:
        """Take the last step back, if there is one."""
        self._at = max(self._at - 1, 0)

    def redo(self) -> None:
        """Make the step again that was taken back last, if there is one."""
        self._at = min(self._at + 1, len(self._states) - 1)


class Undoable(ABC, Generic[State]):
    """What goes from state to state by steps that can be taken back."""

    _history: History[State]

    @abstractmethod
    def _changed(self) -> None:
        """Follow the state that is present now."""

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to take back."""
        return self._history.can_undo

    @property
    def can_redo(self) -> bool:
        """Whether a step was taken back that can be made again."""
        return self._history.can_redo

    def undo(self) -> None:
        """Take the last step back, if there is one."""
        self._history.undo()
        self._changed()

    def redo(self) -> None:
        """Make the step again that was taken back last, if there is one."""
        self._history.redo()
        self._changed()
