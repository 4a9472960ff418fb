"""Files of one camera as the tools of others lay them out, and where it sees the ground."""

import cv2
import numpy as np

SIZE = (1280, 720)
MATRIX = np.array([[900.0, 0, 652], [0, 905, 341], [0, 0, 1]])
LENSES = {
    'plumb_bob': [-0.31, 0.11, 6e-4, -4e-4, -0.018],
    'rational_polynomial': [0.1, 0.02, 1e-4, -2e-4, 0.001, 0.3, 0.05, 0.002],
    'equidistant': [0.0757, -0.0318, 0.004, -0.0007],
}
RVEC, TVEC = np.array([2.1587989303424648, 0.1, -0.05]), np.array([0.3, 0.2, 7.2111025509279791])


def seen(model='plumb_bob', matrix=MATRIX, terms=None, size=SIZE):
    """Return points on the ground, m, and the pixels where OpenCV puts them, in the image."""
    axes = np.arange(-4, 4.1, 0.5), np.arange(-2, 9, 0.5)
    ground = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    world = np.column_stack([ground, np.zeros(len(ground))])[:, None]
    project = cv2.fisheye.projectPoints if model == 'equidistant' else cv2.projectPoints
    terms = np.array(LENSES[model] if terms is None else terms)
    pixel = project(world, RVEC, TVEC, matrix, terms)[0][:, 0]
    inside = ((pixel > 0) & (pixel < size)).all(axis=1)
    assert inside.sum() > 50
    return ground[inside], pixel[inside]


def check_seen(mapping, model='plumb_bob', atol=1e-3, **other):
    """Hold a mapping's positions on the ground against OpenCV's projection, m."""
    ground, pixel = seen(model, **other)
    np.testing.assert_allclose(mapping.ground_from_image(pixel), ground, rtol=0, atol=atol)


def opencv_matrix(values, columns=None):
    """Return a matrix in the YAML of OpenCV's `FileStorage`, below its key."""
    values = np.asarray(values, float)
    rows, columns = (values.size // columns, columns) if columns else (1, values.size)
    listed = ', '.join(map(repr, values.ravel().tolist()))
    return f'!!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: [ {listed} ]'


def opencv_yaml(**values):
    """Return a file of OpenCV's: numbers, texts and arrays by their keys."""
    lines = ['%YAML:1.0', '---']
    for key, value in values.items():
        is_matrix = isinstance(value, np.ndarray)
        lines.append(f'{key}: {opencv_matrix(value, value.shape[-1]) if is_matrix else value}')
    return '\n'.join(lines) + '\n'


def pose_yaml():
    """Return the pose as OpenCV stores it."""
    return opencv_yaml(rvec=RVEC[:, None], tvec=TVEC[:, None])


def tf_pose():
    """Return translation and quaternion of the optical frame on the ground, as TF has them."""
    turn = cv2.Rodrigues(RVEC)[0]
    angle = np.linalg.norm(RVEC)
    quaternion = [*(-np.sin(angle / 2) * RVEC / angle), np.cos(angle / 2)]
    return (-turn.T @ TVEC).tolist(), [float(each) for each in quaternion]


def ros_yaml(model='plumb_bob', matrix=MATRIX, terms=None, key='distortion_model', **more):
    """Return the content of a `camera_calibration` YAML, for `yaml.safe_dump`."""
    terms = LENSES[model] if terms is None else terms
    return {
        'image_width': SIZE[0],
        'image_height': SIZE[1],
        'camera_name': 'narrow',
        'camera_matrix': {'rows': 3, 'cols': 3, 'data': matrix.ravel().tolist()},
        key: model,
        'distortion_coefficients': {'rows': 1, 'cols': len(terms), 'data': list(terms)},
        'rectification_matrix': {'rows': 3, 'cols': 3, 'data': np.eye(3).ravel().tolist()},
        'projection_matrix': {'rows': 3, 'cols': 4, 'data': [0.0] * 12},
    } | more
