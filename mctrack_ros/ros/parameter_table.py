"""The parameter reference; ``python -m mctrack_ros.ros.parameter_table FILE`` writes it."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from mctrack_ros.config import Parameter, parameters_of
from mctrack_ros.ros.default_files import NODE_CONFIGS, yaml_text
from mctrack_ros.site.site import SiteScalars

_INTRODUCTION = """# Parameters

Every parameter of every node, with its default, its unit in square brackets, and what it may be.
The files `config/<node>.yaml` hold the same as ROS parameter files. In a site, the parameters of a
camera stand without `settings.` (`pipeline: {tracker: {vehicles: true}}`), those of fusion under
`fusion`; what else a site may say stands under [Site](#site). A parameter that is unknown, of the
wrong type or out of range stops the node with one line and exit code 2. One
that may be set at run time says so; the others may be set while the node is not configured, and a
node that is says how. Where a parameter names a
method (`local_tracker`, `motion.model`), only the parameters of that method exist; headings say
which these are. `make reference` makes this page from the code; do not edit it."""

_HEAD = (
    '| parameter | default | description | at run time |',
    '| --- | --- | --- | --- |',
)
_SITE = """## Site

The keys of a site YAML. Names of files are relative to it. `cameras` maps a name to the keys of
`settings` of the [camera node](#camera_node), `pipeline` holds those of `settings.pipeline` that
all cameras share, `fusion` those of the [fusion node](#fusion_node). A site that names no
`fusion.tracker` gets the one that suits its calibrations
([which](../explanation/architecture.md#trackers))."""


def parameter_page() -> str:
    """Return the page, Markdown: a section a node, a table a group of its parameters."""
    scalars = [one for one in parameters_of(SiteScalars) if not one.name.startswith('fusion.')]
    parts = [_INTRODUCTION, _SITE, *_tables(scalars)]
    for node, kind in NODE_CONFIGS.items():
        summary = str(sys.modules[kind.__module__].__doc__).strip().splitlines()[0]
        shown = list(parameters_of(kind))
        parts += [f'## {node}', summary, *_tables(shown)]
        for tag in (each for each in shown if each.is_tag):
            parts += _other_methods(kind, tag, shown)
    return '\n\n'.join(parts) + '\n'


def _other_methods(kind: type[Any], tag: Parameter, shown: Sequence[Parameter]) -> Iterator[str]:
    """Yield what methods other than the default one have that is not shown."""
    known = {each.name for each in shown}
    for method in tag.choices:
        parameters = parameters_of(kind, given={tag.name: method})
        own = [each for each in parameters if each.name not in known]
        yield from _tables(own, f', only with `{tag.name}: {method}`')


def _tables(parameters: Iterable[Parameter], condition: str = '') -> Iterator[str]:
    """Yield the heading of each group that has one, with a condition, and its table."""
    for group, members in groupby(parameters, lambda one: one.name.rpartition('.')[0]):
        if group:
            yield f'### {group}{condition}'
        rows = [
            f'| `{one.name.rpartition(".")[2]}` | `{yaml_text(one.default)}` '
            f'| {one.explained().replace("|", "&#124;")} | {"yes" if one.at_run_time else ""} |'
            for one in members
        ]
        yield '\n'.join([*_HEAD, *rows])


if __name__ == '__main__':
    Path(sys.argv[1]).write_text(parameter_page(), encoding='utf-8')
