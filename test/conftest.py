"""What tests of several folders share."""

import pytest

from here import RenderingHere


@pytest.fixture
def rendering_here(monkeypatch):
    """Let `simulate` render in this process."""
    monkeypatch.setattr('mctrack_ros.simulation.recording.ProcessPoolExecutor', RenderingHere)
