"""The XML launch files, made from the arguments of those in Python, which they include."""

from __future__ import annotations

import sys
from pathlib import Path
from xml.etree.ElementTree import Element, ElementTree, SubElement, indent

from mctrack_ros.cli.launch_files import (
    CALIBRATION,
    REPLAY,
    SIMULATION,
    SITE,
)
from mctrack_ros.ros.graph.launch_actions import Arguments

FILES: dict[str, Arguments] = {
    'calibration': CALIBRATION,
    'replay': REPLAY,
    'simulation': SIMULATION,
    'site': SITE,
}


def write_launch_xml(folder: Path) -> list[Path]:
    """Write all XML launch files into a folder; return them."""
    made = []
    for name, arguments in FILES.items():
        root = Element('launch')
        file = f'$(dirname)/{name}.launch.py'
        include = Element('include', file=file)
        for argument, (default, text) in arguments.items():
            stated = {} if default is None else {'default': default}
            SubElement(root, 'arg', {'name': argument, **stated, 'description': text})
            SubElement(include, 'arg', name=argument, value=f'$(var {argument})')
        root.append(include)
        indent(root, '    ')
        path = folder / f'{name}.launch.xml'
        ElementTree(root).write(path, encoding='unicode')
        path.write_text(f'{path.read_text(encoding="utf-8")}\n', encoding='utf-8')
        made.append(path)
    return made


if __name__ == '__main__':
    for path in write_launch_xml(Path(sys.argv[1])):
        print(path)
