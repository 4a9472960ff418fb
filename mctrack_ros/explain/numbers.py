"""An explanation as JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from mctrack_ros.explain.history import TrackHistory
from mctrack_ros.explain.words import course, sentences
from mctrack_ros.interfaces import Choice, Explanation, Reason, Rows, TrackStatus


def write_history(history: TrackHistory, path: Path) -> None:
    """Write all that is known from the instant asked about on; NaN becomes null."""
    content = {
        'track_id': history.track_id,
        'cameras': list(history.cameras),
        'gate': history.gate,
        'is_stored': history.is_stored,
        'is_same': history.is_same,
        'sentences': sentences(history),
        'course': list(course(history)),
        'ticks': [_tick(history, each) for each in history.explanations[history.index :]],
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content, indent=1, allow_nan=False) + '\n')


def _tick(history: TrackHistory, explanation: Explanation) -> dict[str, Any]:
    candidates, decisions = _plain(explanation.candidates), _plain(explanation.decisions)
    for row in candidates:
        row['choice'] = Choice(row['choice']).name
    for row in decisions:
        row['reason'] = Reason(row['reason']).name
        row['status'] = TrackStatus(row['status']).name
    return {
        'seconds': history.seconds(explanation.stamp_ns),
        'stamp_ns': explanation.stamp_ns,
        'candidates': candidates,
        'decisions': decisions,
    }


def _plain(rows: Rows) -> list[dict[str, Any]]:
    columns = {}
    for name in rows.COLUMNS:
        values = getattr(rows, name)
        plain = values.astype(object)
        if values.dtype.kind == 'f':
            plain[~np.isfinite(values)] = None
        columns[name] = plain.tolist()
    return [dict(zip(columns, row)) for row in zip(*columns.values())]
