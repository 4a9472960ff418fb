"""What a page does when somebody does something on it."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui
from nicegui.events import KeyEventArguments


def handler_of(
    step: Callable[..., object], refused: type[Exception], changed: Callable[[], object]
) -> Callable[..., None]:
    """
    Return a handler that takes a step and shows what came of it.

    Parameters
    ----------
    step : callable
        Takes what the event gives.
    refused : type
        What it raises where it may not be; shown as a notice.
    changed : callable
        Draws the page anew.

    """

    def handler(*arguments: object) -> None:
        try:
            step(*arguments)
        except refused as error:
            ui.notify(str(error), type='warning')
        changed()

    return handler


def pressed(event: KeyEventArguments) -> str:
    """Return what a key asks for: undo, redo, delete or escape; empty: nothing."""
    if not event.action.keydown:
        return ''
    key = event.key.name.lower()
    if event.modifiers.ctrl or event.modifiers.meta:
        again = key == 'y' or (key == 'z' and event.modifiers.shift)
        if again or key == 'z':
            return 'redo' if again else 'undo'
    return {'delete': 'delete', 'backspace': 'delete', 'escape': 'escape'}.get(key, '')
