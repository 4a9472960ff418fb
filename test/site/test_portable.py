import pytest
import yaml

from mctrack_ros.site.portable import FOLDER, SITE_FILE, portable_site


@pytest.mark.parametrize('private', [True, False])
def test_a_private_site_travels_without_pictures(tmp_path, private):
    for name in ('cam1.xml', 'empty.png'):
        (tmp_path / name).write_bytes(b'what it holds')
    camera = {'grid': 'cam1.xml', 'background': 'empty.png'}
    path = tmp_path / 'site.yaml'
    path.write_text(yaml.safe_dump({'private': private, 'cameras': {'cam1': camera}}))
    files = portable_site(path)
    told = yaml.safe_load(files.pop(f'{FOLDER}/{SITE_FILE}'))['cameras']['cam1']
    kinds = {'grid'} if private else {'grid', 'background'}
    assert set(told) == kinds
    assert set(files) == {f'{FOLDER}/{named}' for named in told.values()}
