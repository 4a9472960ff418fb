"""`mctrack reproduce terrace --live`: two video files as two cameras."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from mctrack_experiments.real.terrace.videos import terrace_figures, video, write_site
from mctrack_ros.cli.live import run_to_end
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ros.graph.graph import NodeSpec, recorder_node
from mctrack_ros.ros.graph.site_graph import site_nodes

_PREPARATION_S = 8.0
"""From the start of the processes to the first image."""

_SECONDS = 120.0
_RATE_HZ = 25.0


def track_terrace_live(data: Path) -> Figures:
    """
    Play both clips in step into the real graph and measure what comes of it.

    Parameters
    ----------
    data : Path
        Folder of the real data.

    """
    with tempfile.TemporaryDirectory(prefix='mctrack_terrace_') as name:
        folder = Path(name)
        site = write_site(data, folder)
        start = time.time() + _PREPARATION_S
        videos = [
            NodeSpec(
                'video_node',
                f'{camera}_video',
                {
                    'camera': camera,
                    'source': str(video(data, camera)),
                    'rate': _RATE_HZ,
                    'start': start,
                },
                restart=False,
                ends=True,
            )
            for camera in site.camera_names
        ]
        recorder = recorder_node(folder / 'bag', ['/(tracks|ticks)', '/c./detections'])
        run_to_end([*site_nodes(site), recorder, *videos], folder / 'graph.log', None)
        return terrace_figures(folder / 'bag', _SECONDS)
