"""A site of two cameras of the simulated pitch."""

from mctrack_ros.ground import write_grid
from mctrack_ros.simulation import Scenario, pitch5_cameras
from mctrack_ros.simulation.calibration import camera_grid
from mctrack_ros.site.site import load_site


def write_site(folder):
    """Write two.yaml and its grids; return the site."""
    for camera in pitch5_cameras(Scenario())[:2]:
        write_grid(camera_grid(camera), folder / f'{camera.name}.xml')
    size = 'image_width: 768, image_height: 576'
    cameras = [f'  {name}: {{grid: {name}.xml, {size}}}' for name in ('cam1', 'cam2')]
    lines = ['name: two', 'area: 0,0,105,68', 'cameras:', *cameras]
    (folder / 'two.yaml').write_text('\n'.join(lines) + '\n')
    return load_site(folder / 'two.yaml')
