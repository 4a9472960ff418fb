"""How the cameras are: by `/diagnostics`, and by silence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

SILENT_S = 3.5
"""Parts report once a second: who says nothing for so long is gone."""
_LEVELS = ('good', 'warning', 'error', 'error')
_RATE = 'rate [Hz]'


class Status(Protocol):
    """What `/diagnostics` says of a part."""

    name: str
    hardware: str
    level: int
    message: str
    values: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class _Heard:
    status: Status
    at_s: float


class Health:
    """
    The state of cameras, and of all that belongs to none.

    Parameters
    ----------
    cameras : sequence of str
        Their names.

    """

    def __init__(self, cameras: Sequence[str]) -> None:
        self.cameras = tuple(cameras)
        self._heard: dict[str, _Heard] = {}

    def hear(self, statuses: Sequence[Status], now_s: float) -> None:
        """Take what came at a time of a steady clock, s."""
        for status in statuses:
            self._heard[status.name] = _Heard(status, now_s)

    def report(self, now_s: float) -> list[dict[str, Any]]:
        """
        Return the state of each camera, then that of the other parts together.

        As ``{name, level, text, rate}``; levels are good, warning, error, silent and waiting:
        nothing was ever heard.
        """
        of_camera: dict[str, list[_Heard]] = {name: [] for name in self.cameras}
        others: list[_Heard] = []
        for heard in self._heard.values():
            of_camera.get(heard.status.hardware.rsplit('/', 1)[-1], others).append(heard)
        named = [*of_camera.items(), ('tracker', others)]
        return [_judged(name, heard, now_s) for name, heard in named]


def _judged(name: str, heard: Sequence[_Heard], now_s: float) -> dict[str, Any]:
    """Return the worst of what is not older than `SILENT_S`."""
    fresh = [each.status for each in heard if now_s - each.at_s <= SILENT_S]
    if not fresh:
        since_s = now_s - max((each.at_s for each in heard), default=now_s)
        level, text = (
            ('silent', f'nothing heard for {since_s:.0f} s') if heard else ('waiting', '')
        )
        return {'name': name, 'level': level, 'text': text, 'rate': ''}
    worst = max(fresh, key=lambda each: each.level)
    part = worst.name.partition(': ')[2] or worst.name
    text = f'{part}: {worst.message}' if worst.level else ''
    rates = [each.values[_RATE] for each in fresh if _RATE in each.values]
    return {
        'name': name,
        'level': _LEVELS[min(worst.level, 3)],
        'text': text,
        'rate': rates[0] if rates else '',
    }
