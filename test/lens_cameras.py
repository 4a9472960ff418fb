"""Cameras to test with."""

import cv2
import numpy as np

from mctrack_ros.ground import Camera, CameraMapping

SIZE = (720, 576)


def camera(
    eye=(3.0, -30.0, 15.0), target=(0.0, 12.0, 0.0), focal=650.0, distortion=(-0.2, 0, 0, 0, 0)
):
    """Return a camera's mapping; its principal point is the image's centre."""
    eye, target = np.array(eye, float), np.array(target, float)
    forward = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.array([right, np.cross(forward, right), forward])
    intrinsics = np.array([focal, focal, SIZE[0] / 2, SIZE[1] / 2])
    return CameraMapping(Camera(intrinsics, np.array(distortion), rotation, -rotation @ eye), SIZE)


def seen_grid(mapping, spacing=4.0, reach=60.0):
    """Return the points of a square grid on the ground that a camera sees, m."""
    axis = np.arange(-reach, reach + spacing / 2, spacing)
    points = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    pixel = mapping.image_from_ground(points)
    inside = (pixel >= 0).all(axis=1) & (pixel < mapping.image_size).all(axis=1)
    return points[inside]


def missed(stored):
    """Return, for pixels all over the image, how far the lens misses and the share of a fold."""
    axes = [np.linspace(0, side, side // 8) for side in stored.image_size]
    pixel = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    sensor = (pixel - stored.centre) / stored.per_mm
    square = (sensor**2).sum(axis=1, keepdims=True)
    ideal = sensor * (1 + stored.kappa1 * square) / stored.focal_mm
    camera = stored.camera()
    across, down, x, y = camera.intrinsics
    matrix = np.array([[across, 0, x], [0, down, y], [0, 0, 1]])
    world = np.column_stack([ideal, np.ones(len(ideal))])
    seen = cv2.projectPoints(world, np.zeros(3), np.zeros(3), matrix, camera.distortion)[0]
    fold = np.sqrt(np.maximum(-3 * stored.kappa1 * square[:, 0], 0))
    return np.linalg.norm(seen[:, 0] - pixel, axis=1), fold
