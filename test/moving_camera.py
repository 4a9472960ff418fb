"""Images of a textured square, as a camera sees it that moves."""

import cv2
import numpy as np

SIZE = (480, 360)
MARGIN = 80


def ground(seed=0):
    """Return blocks and grain, larger than the image by a margin."""
    rng = np.random.default_rng(seed)
    coarse = rng.integers(40, 200, ((SIZE[1] + 2 * MARGIN) // 20, (SIZE[0] + 2 * MARGIN) // 20, 3))
    size = (SIZE[0] + 2 * MARGIN, SIZE[1] + 2 * MARGIN)
    blocks = cv2.resize(coarse.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    grain = rng.normal(0, 4, blocks.shape)
    return np.clip(cv2.GaussianBlur(blocks, (0, 0), 1.0) + grain, 0, 255).astype(np.uint8)


def seen(still, right=0.0, down=0.0, turn_deg=0.0):
    """Return the image when its content has moved by so much about the middle."""
    middle = np.array(SIZE) / 2
    place = middle + np.array([right, down])
    matrix = cv2.getRotationMatrix2D((0, 0), -turn_deg, 1.0)
    matrix[:, 2] = place - matrix[:, :2] @ (middle + MARGIN)
    return cv2.warpAffine(still, matrix, SIZE)
