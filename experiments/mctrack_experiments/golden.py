"""
The golden bags: images of two scenes, and what five cameras detected in a short match.

``python -m mctrack_experiments.golden bags`` makes them again, and the scores of the match.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from mctrack_ros.codec import compressed_message, image_from_message, jpeg_from_image
from mctrack_ros.evaluation.comparison import compare
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.recording import ROSBAGS_CLASSES, BagReader, BagWriter
from mctrack_ros.replay.track import track_bag
from mctrack_ros.resources import config_file
from mctrack_ros.simulation import CarParkScenario, Scenario
from mctrack_ros.simulation.recording import simulate
from mctrack_ros.site.site import load_site

NAME = 'pitch5_detections'
SCENARIO = Scenario(seed=7, duration_s=6.0)


IMAGES = {
    'pitch5_pictures': Scenario(seed=7, duration_s=3.0, cameras=2, noise=0.5),
    'carpark_pictures': CarParkScenario(seed=11, duration_s=20.0),
}
_JPEG_QUALITY = 70


def write_images(name: str, folder: Path) -> None:
    """Simulate a scene and keep its images, compressed further to stay small."""
    with tempfile.TemporaryDirectory(prefix='mctrack_golden_') as scratch:
        simulate(IMAGES[name], Path(scratch) / 'scene')
        with (
            BagReader(Path(scratch) / 'scene') as reader,
            BagWriter(folder / name, overwrite=True) as writer,
        ):
            topics = [topic for topic in reader.topics if topic.endswith('/compressed')]
            for topic, message, time_ns in reader.messages(topics):
                jpeg = jpeg_from_image(image_from_message(message), _JPEG_QUALITY)
                packed = compressed_message(
                    jpeg, ROSBAGS_CLASSES, time_ns, message.header.frame_id
                )
                writer.write(topic, packed, time_ns)


def write_golden(folder: Path) -> Figures:
    """Simulate, detect, keep the detections and the truth; track those and keep the scores."""
    site = load_site(config_file('pitch5.yaml'))
    golden = folder / NAME
    with tempfile.TemporaryDirectory(prefix='mctrack_golden_') as name:
        scratch = Path(name)
        simulate(SCENARIO, scratch / 'match')
        track_bag(scratch / 'match', scratch / 'tracked', site)
        kept = {
            '/truth/tracks': scratch / 'match',
            **{f'/{camera}/detections': scratch / 'tracked/bag' for camera in site.cameras},
        }
        with BagWriter(golden, overwrite=True) as writer:
            for topic, source in kept.items():
                with BagReader(source) as reader:
                    for item in reader.serialized([topic]):
                        writer.write_copy(reader, *item)
        figures = golden_figures(golden, scratch / 'again')
    figures.write(folder / f'{NAME}.json')
    return figures


def golden_figures(golden: Path, scratch: Path) -> Figures:
    """Track the golden bag's detections and score the tracks against its truth."""
    site = load_site(config_file('pitch5.yaml'))
    track_bag(golden, scratch, site, processes=1)
    figures = compare(golden, scratch / 'bag', 1.0)
    return replace(figures, command='python -m mctrack_experiments.golden bags')


if __name__ == '__main__':
    for images in IMAGES:
        write_images(images, Path(sys.argv[1]))
    print(write_golden(Path(sys.argv[1])).table())
