"""A small bag of drawn images with two cameras, and its site."""

import cv2
import numpy as np
import yaml

from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter
from mctrack_ros.site.site import load_site

SIZE = (320, 240)
PERIOD_NS = 40_000_000
EMPTY_S = 1.5

VIEWS = {'north': (0.0, -22.0, 9.0), 'south': (4.0, 22.0, 9.0)}


def projection(position, target=(0.0, 0.0, 0.0), focal=330.0):
    """Return the (3, 4) matrix of a camera that looks at a target."""
    position = np.asarray(position)
    forward = np.asarray(target) - position
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    intrinsics = np.array([[focal, 0, SIZE[0] / 2], [0, focal, SIZE[1] / 2], [0, 0, 1]])
    return intrinsics @ np.column_stack([rotation, -rotation @ position])


def walkers(seconds):
    """Return where three people are, (3, 2) m: two walk in circles, one to and fro."""
    phase = 0.4 * seconds
    return np.array(
        [
            [3 * np.cos(phase), 3 * np.sin(phase)],
            [-4 * np.cos(phase), 2.5 * np.sin(phase)],
            [5 * np.sin(0.7 * phase), -4.0],
        ]
    )


def image(mapping, people, rng, colours=None, legs=None):
    """Draw people as upright boxes on a noisy floor, the far ones first."""
    image = np.full((SIZE[1], SIZE[0], 3), 110, np.uint8)
    colours = np.array(colours or [(40, 40, 200), (200, 60, 40), (40, 190, 200)])
    feet, heads = mapping.image_from_ground(people), mapping.image_from_ground(people, 1.8)
    for index in np.argsort(feet[:, 1]):
        (x, bottom), top = feet[index], heads[index, 1]
        half = (bottom - top) / 6
        corner, opposite = (round(x - half), round(top)), (round(x + half), round(bottom))
        cv2.rectangle(image, corner, opposite, colours[index].tolist(), -1)
        if legs is not None:
            waist = (corner[0], round((top + bottom) / 2))
            cv2.rectangle(image, waist, opposite, legs, -1)
    noise = rng.integers(-4, 5, image.shape)
    return np.clip(image + noise, 0, 255).astype(np.uint8)


def write_hall(folder, seconds=7.5, offset_ns=0, positions=None, start=None):
    """
    Write the bag and its site below a folder.

    The floor is empty for the first moments; ``offset_ns`` delays the camera 'south';
    other cameras are given by their positions, and by rows what starts tracks.
    """
    cameras = {}
    with BagWriter(folder / 'bag') as writer:
        views = {}
        for name, position in (positions or VIEWS).items():
            matrix = projection(position)
            views[name] = ProjectiveMapping(matrix, SIZE)
            (folder / f'{name}.yaml').write_text(f'image_from_world: {matrix.tolist()}')
            cameras[name] = {
                'calibration': f'{name}.yaml',
                'image_width': SIZE[0],
                'image_height': SIZE[1],
            }
        if start is not None:
            writer.write_rows('/start', start, 'map', start.stamp_ns)
        rng = np.random.default_rng(5)
        for index in range(round(seconds * 25)):
            for name, mapping in views.items():
                late = offset_ns if name == 'south' else 0
                stamp_ns = 10**12 + index * PERIOD_NS + PERIOD_NS // 4 + late
                people = walkers(stamp_ns * 1e-9 - 1000)
                drawn = image(mapping, people[: 0 if index < EMPTY_S * 25 else None], rng)
                message = compressed_message(
                    jpeg_from_image(drawn), ROSBAGS_CLASSES, stamp_ns, f'{name}_optical_frame'
                )
                writer.write(f'/{name}/image_raw/compressed', message, stamp_ns)
    (folder / 'site.yaml').write_text(yaml.safe_dump({'name': 'hall', 'cameras': cameras}))
    return folder / 'bag', load_site(folder / 'site.yaml')
