import cv2
import numpy as np
import pytest

from mctrack_ros.codec import compressed_message, jpeg_from_image
from mctrack_ros.recording import ROSBAGS_CLASSES, BagWriter
from mctrack_ros.web import ImageError
from mctrack_ros.web.coverage.site_images import site_images
from web.fields import write_site


@pytest.fixture
def site(tmp_path):
    return write_site(tmp_path)


def image(level, width=768):
    return np.full((576, width, 3), level, np.uint8)


def test_each_camera_has_a_source_of_its_own_or_that_of_all(site, tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        for level, camera in ((40, 'cam1'), (80, 'cam2')):
            jpeg = jpeg_from_image(image(level))
            message = compressed_message(jpeg, ROSBAGS_CLASSES, 1, camera)
            bag.write(f'/{camera}/image_raw/compressed', message, 1)
    cv2.imwrite(str(tmp_path / 'cam1.png'), image(120))
    everyone, own = str(tmp_path / 'bag'), f'cam1={tmp_path / "cam1.png"}'
    means = [
        {name: round(found.mean()) for name, found in site_images(site, sources).items()}
        for sources in ([everyone], [everyone, own], [own, everyone], [own], [])
    ]
    assert means[0] == {'cam1': 40, 'cam2': 80}
    assert means[1] == means[2] == {'cam1': 120, 'cam2': 80}
    assert means[3:] == [{'cam1': 120}, {}]


def test_an_image_that_cannot_be_the_camera_s_is_refused(site, tmp_path):
    cv2.imwrite(str(tmp_path / 'small.png'), image(120, width=700))
    with pytest.raises(ImageError, match='has 700 x 576 px, the site says 768 x 576'):
        site_images(site, [f'cam1={tmp_path / "small.png"}'])
    with pytest.raises(ImageError, match='expected one of the cameras cam1, cam2'):
        site_images(site, ['cam9=cam9.png'])
    with pytest.raises(ImageError, match='is no bag: name its camera, for example cam1='):
        site_images(site, ['a.png'])
