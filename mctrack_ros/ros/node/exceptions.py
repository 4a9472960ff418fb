"""Exceptions that end no node: counted, said in one line, reported on `/diagnostics`."""

from __future__ import annotations

import traceback
from dataclasses import dataclass

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue


@dataclass(slots=True)
class Exceptions:
    """
    What callbacks of a node have raised.

    Attributes
    ----------
    count, reported : int
        Exceptions since the start, and at the last report.
    last : str
        What the last one says, and where it was raised.

    """

    count: int = 0
    reported: int = 0
    last: str = ''

    def note(self, error: Exception) -> str:
        """Count an exception and return it in one line."""
        self.count += 1
        place = traceback.extract_tb(error.__traceback__)[-1]
        text = ' '.join(str(error).split())
        self.last = f'{type(error).__name__}: {text} ({place.filename}:{place.lineno})'
        return self.last

    def report(self, name: str) -> DiagnosticStatus:
        """Return the state: an error if anything was raised since the last report."""
        level, message = DiagnosticStatus.OK, 'no exception'
        if self.count:
            level, message = DiagnosticStatus.WARN, f'{self.count} so far; the last: {self.last}'
        if self.count > self.reported:
            level = DiagnosticStatus.ERROR
        self.reported = self.count
        return DiagnosticStatus(
            level=level,
            name=name,
            message=message,
            values=[KeyValue(key='exceptions', value=str(self.count))],
        )
