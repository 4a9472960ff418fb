"""Real boxes by the commands: PETS 2009 S2.L1, lenses and all, beside the experiment's figure."""

import gzip
import json
import re

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from mctrack_experiments.datasets import pets_multiview
from mctrack_experiments.datasets.pets_multiview import (
    IMAGE_SIZES,
    LEAST_SCORE,
    RATE,
    load_pets_multiview,
)
from mctrack_experiments.datasets.stored import inside
from mctrack_experiments.real.stored.tracking import track_stored
from mctrack_ros.cli.main import app
from mctrack_ros.evaluation import evaluate_ground
from mctrack_ros.interfaces import Detections
from mctrack_ros.perception.boxes import BodyModel
from mctrack_ros.recording import BagReader

VIEWS = (1, 5)
AREA = ((-14.0, 2.0), (-14.0, 4.0))


def mctrack(*arguments):
    result = CliRunner().invoke(app, [*map(str, arguments)], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def write_site(data, folder):
    """Write a site of OpenCV's calibrations, in millimetres and with lenses, and MOT text."""
    stored = json.loads((data / 'calibration' / 'mot3d_calibration.json').read_text())
    cameras = []
    for view in VIEWS:
        camera, (width, height) = stored[f'View_{view:03d}'], IMAGE_SIZES[view]
        file = cv2.FileStorage(str(folder / f'view{view}.yaml'), cv2.FILE_STORAGE_WRITE)
        for key, value in (('image_width', width), ('image_height', height)):
            file.write(key, value)
        for key, name, shape in (
            ('camera_matrix', 'K', (3, 3)),
            ('distortion_coefficients', 'dist', (1, 5)),
            ('rotation_matrix', 'R', (3, 3)),
            ('translation_vector', 't', (3, 1)),
        ):
            file.write(key, np.array(camera[name], float).reshape(shape))
        file.release()
        cameras.append(
            f'  view{view}: {{calibration: view{view}.yaml, length_unit: mm, '
            f'image_width: {width}, image_height: {height}}}\n'
        )
        name = f'keypointsrcnn_resnet50_fpn_View_{view:03d}_finetuned_2.json.gz'
        seen = json.loads(gzip.decompress((data / 'detections_multiview' / name).read_bytes()))
        with open(folder / f'view{view}.txt', 'w') as file:
            for frame, (boxes, scores) in enumerate(zip(seen['bboxes'], seen['scores']), 1):
                for (left, top, right, bottom), score in zip(boxes, scores):
                    file.write(f'{frame},-1,{left},{top},{right - left},{bottom - top},{score}\n')
    (folder / 'pets.yaml').write_text(
        f'name: pets\nfeedback_delay: 0.3\nfusion: {{batching: {{period: {1 / RATE}}}}}\n'
        f'cameras:\n{"".join(cameras)}'
    )


@pytest.mark.real_data
def test_commands_make_of_real_boxes_what_the_experiment_does(data_root, tmp_path, monkeypatch):
    monkeypatch.setattr(pets_multiview, 'VIEWS', VIEWS)
    data = data_root / 'pets2009_s2l1'
    write_site(data, tmp_path)
    said = mctrack(
        *('import-detections', tmp_path / 'bag'),
        *(f'view{view}={tmp_path / f"view{view}.txt"}' for view in VIEWS),
        *('--site', tmp_path / 'pets.yaml', '--rate', RATE, '--least-score', LEAST_SCORE),
    )
    assert 'view1: 4769 detections of 8857 in 795 images' in said
    scene = load_pets_multiview(data, BodyModel())
    with BagReader(tmp_path / 'bag') as reader:
        for camera in (f'view{view}' for view in VIEWS):
            rows = [rows for rows, _ in reader.rows(f'/{camera}/detections', Detections)]
            apart = [
                np.linalg.norm(one.position[:, :2] - other.position[:, :2], axis=1)
                for one, other in zip(rows, scene.detections[camera])
                if len(one) == len(other)
            ]
            assert len(apart) > 780
            assert np.quantile(np.concatenate(apart), 0.9) < 0.05

    mctrack('track', tmp_path / 'bag', '--site', tmp_path / 'pets.yaml', '--out', tmp_path / 'out')
    (left, right), (low, high) = AREA
    figures = mctrack(
        *('evaluate', data / 'gt' / '3DMOT2015_PETS09-S2L1_gt.txt', tmp_path / 'out'),
        *(f'--area={left},{low},{right},{high}', '--rate', RATE),
    )
    mota = float(re.search(r'mota +([\d.]+)', figures)[1])
    tracks = track_stored(scene, {}, tuple(f'view{view}' for view in VIEWS))
    kept = [rows.select(inside(rows.position, AREA)) for rows in (scene.truth, tracks)]
    expected = evaluate_ground(*kept, 1.0).mota
    assert expected > 0.8
    assert mota == pytest.approx(expected, abs=0.02)
