"""The parameters of all other nodes in the graph."""

from __future__ import annotations

from functools import partial
from typing import Any

import yaml
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.task import Future


class NodeParameters:
    """
    Asks each node once for its parameters.

    Parameters
    ----------
    node : Node
        Which asks.

    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._asked = {node.get_fully_qualified_name()}
        self._waiting: dict[str, Client[Any, Any]] = {}
        self._values: dict[str, dict[str, Any]] = {}
        self._has_news = False

    def look(self) -> None:
        """Ask the nodes that have appeared."""
        for name, space in self._node.get_node_names_and_namespaces():
            full = f'{space.rstrip("/")}/{name}'
            if full not in self._asked and not name.startswith('_'):
                self._asked.add(full)
                listed = f'{full}/list_parameters'
                self._waiting[full] = self._node.create_client(ListParameters, listed)
        for full, client in list(self._waiting.items()):
            if client.service_is_ready():
                answer = self._waiting.pop(full).call_async(ListParameters.Request())
                answer.add_done_callback(partial(self._listed, full))

    def begin(self) -> None:
        """Count all that is known as news."""
        self._has_news = bool(self._values)

    def news(self) -> bytes:
        """Return all parameters as a ROS parameter file if some are new, else nothing."""
        if not self._has_news:
            return b''
        self._has_news = False
        values = {name: {'ros__parameters': self._values[name]} for name in sorted(self._values)}
        return yaml.safe_dump(values).encode()

    def _listed(self, full: str, answer: Future[Any]) -> None:
        names = list(answer.result().result.names)
        client = self._node.create_client(GetParameters, f'{full}/get_parameters')
        values = client.call_async(GetParameters.Request(names=names))
        values.add_done_callback(partial(self._given, full, names))

    def _given(self, full: str, names: list[str], answer: Future[Any]) -> None:
        values = map(parameter_value_to_python, answer.result().values)
        self._values[full] = {
            name: list(value) if hasattr(value, 'tolist') else value
            for name, value in zip(names, values)
        }
        self._has_news = True
