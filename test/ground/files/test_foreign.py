"""Files of ORB-SLAM, RealSense and camodocal: refused, with what to write instead."""

import re

import pytest
from typer.testing import CliRunner

from mctrack_ros.cli.main import app
from mctrack_ros.ground import read_calibration
from written_cameras import LENSES, MATRIX, SIZE, check_seen, pose_yaml

FX, FY, CX, CY = MATRIX[[0, 1, 0, 1], [0, 1, 2, 2]].tolist()
NARROW = dict(zip(('k1', 'k2', 'p1', 'p2', 'k3'), LENSES['plumb_bob']))
WIDE = dict(zip(('k1', 'k2', 'k3', 'k4'), LENSES['equidistant']))
FULL = dict(zip(('k1', 'k2', 'p1', 'p2', 'k3', 'k4', 'k5', 'k6'), LENSES['rational_polynomial']))
ROOM = {'image_width': SIZE[0], 'image_height': SIZE[1]}
PINHOLE = {'fx': FX, 'fy': FY, 'cx': CX, 'cy': CY}


def lines(values, start=''):
    return ''.join(f'{start}{key}: {value}\n' for key, value in values.items())


def orb_slam(lens, kind, more=''):
    sizes = dict(zip(('width', 'height'), SIZE))
    return (
        f'%YAML:1.0\n\nCamera.type: "{kind}"\n{lines(PINHOLE | lens | sizes, "Camera.")}'
        f'Camera.fps: 30.0\nCamera.RGB: 1\nORBextractor.nFeatures: 1200\n{more}'
    )


def camodocal(kind, lens, projection, more=''):
    return (
        f'%YAML:1.0\n---\nmodel_type: {kind}\ncamera_name: camera\n{lines(ROOM)}{more}'
        f'distortion_parameters:\n{lines(lens, "   ")}'
        f'projection_parameters:\n{lines(projection, "   ")}'
    )


NEAR = {key: NARROW[key] for key in ('k1', 'k2', 'p1', 'p2')}
BODY = 'Tbc: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: f\n   data: [1.0, 0.0]\n'
DEVICE = (
    'Device info: \n    Name                          : \tIntel RealSense D455\n\n'
    'Intrinsic Parameters:\n\nIntrinsic of "Color" / 1280x720 / {YUYV/RGB8}\n'
    f'  Width:      \t{SIZE[0]}\n  Height:     \t{SIZE[1]}\n  PPX:        \t{CX}\n'
    f'  PPY:        \t{CY}\n  Fx:         \t{FX}\n  Fy:         \t{FY}\n'
    f'  Distortion: \tBrown Conrady\n  Coeffs:     \t{"  ".join(map(str, NARROW.values()))}\n'
)
STREAM = (
    f'{{"width": {SIZE[0]}, "height": {SIZE[1]}, "ppx": {CX}, "ppy": {CY}, "fx": {FX}, '
    f'"fy": {FY}, "model": "distortion.brown_conrady", "coeffs": {[*NARROW.values()]}}}'
)
OF_DEVICE = {'ppx': CX, 'ppy': CY, 'width': SIZE[0], 'height': SIZE[1]} | {
    'its five coeffs': [*NARROW.values()]
}
MEI = {'gamma1': FX, 'gamma2': FY, 'u0': CX, 'v0': CY}
BRANDT = {'mu': FX, 'mv': FY, 'u0': CX, 'v0': CY}
BRANDT_LENS = dict(zip(('k2', 'k3', 'k4', 'k5'), LENSES['equidistant']))
FILES = {
    'ORB-SLAM': (orb_slam(NARROW, 'PinHole'), NARROW),
    'ORB-SLAM with an IMU': (orb_slam(NARROW, 'PinHole', BODY), NARROW),
    'ORB-SLAM, wide': (orb_slam(WIDE, 'KannalaBrandt8'), WIDE),
    'fx and so on of a script': (lines(PINHOLE | NARROW), NARROW),
    'rs-enumerate-devices -c': (DEVICE, OF_DEVICE),
    'librealsense JSON': (STREAM, OF_DEVICE),
    'librealsense JSON, deeper': (f'{{"intrinsics": {STREAM}}}', OF_DEVICE),
    'camodocal PINHOLE': (camodocal('PINHOLE', NEAR, PINHOLE), NEAR),
    'camodocal PINHOLE_FULL': (camodocal('PINHOLE_FULL', FULL, PINHOLE), FULL),
    'camodocal KANNALA_BRANDT': (
        camodocal('KANNALA_BRANDT', {}, BRANDT_LENS | BRANDT), BRANDT | BRANDT_LENS
    ),
    'camodocal MEI': (
        camodocal('MEI', NEAR, MEI, 'mirror_parameters:\n   xi: 0.0\n'), MEI | NEAR | {'xi': 0.0}
    ),
}  # fmt: skip
EXPECTED = {
    'ORB-SLAM, wide': {'model': 'equidistant'},
    'camodocal PINHOLE_FULL': {'model': 'rational_polynomial'},
    'camodocal KANNALA_BRANDT': {'model': 'equidistant'},
} | {
    name: {'terms': [*NEAR.values(), 0.0]} for name in ('camodocal PINHOLE', 'camodocal MEI')
}  # fmt: skip

KEY = r'camera_\w+|distortion_\w+|image_\w+|intrinsics|resolution'


@pytest.fixture
def refused(tmp_path):
    """Return a function that gives a file to a command and returns the error."""

    def told(content):
        path = tmp_path / 'camera.yaml'
        path.write_text(content)
        out = tmp_path / 'out.yaml'
        done = CliRunner().invoke(app, ['convert-calibration', str(path), str(out)])
        assert done.exit_code == 1, done.output
        assert '\n' not in str(done.exception)
        return str(done.exception)

    return told


def as_said(reason, values):
    """Return the lines that a refusal asks for, with the values in place of their names."""
    stated = re.findall(rf'({KEY}): (\[[^]]*\]|its five coeffs|\w+)', reason)
    stated += [(key, key) for key in re.findall(r', (image_width|image_height)\b(?!:|\])', reason)]
    return {
        key: re.sub(
            r'its five coeffs|[a-z]\w*', lambda name: str(values.get(name[0], name[0])), text
        )
        for key, text in stated
    }


@pytest.mark.parametrize('tool', FILES)
def test_what_a_refusal_asks_for_is_the_same_camera(refused, tmp_path, tool):
    content, values = FILES[tool]
    reason = refused(content)
    assert 'not read in this form; write a YAML of' in reason
    stated = as_said(reason, PINHOLE | ROOM | values)
    path = tmp_path / 'written.yaml'
    path.write_text('cam0:\n' + lines(stated, '  ') if 'camera_model' in stated else lines(stated))
    (tmp_path / 'pose.yml').write_text(pose_yaml())
    mapping = read_calibration(path, SIZE, tmp_path / 'pose.yml')
    check_seen(mapping, **{'atol': 0.03} | EXPECTED.get(tool, {}))


def test_a_polynomial_of_scaramuzzas_is_to_be_calibrated_otherwise(refused):
    reason = refused('%YAML:1.0\n---\nmodel_type: scaramuzza\npoly_parameters:\n   p0: -200.0\n')
    assert 'calibrate it as KANNALA_BRANDT' in reason
