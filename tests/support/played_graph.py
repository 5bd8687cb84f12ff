# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What the ROS client sees of ROS, played."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any


class Future:
    """The response to one message."""

    def __init__(self, message: Any) -> None:
        self.message = message
        self._callbacks: list[Callable[[Future], None]] = []
        self._response: object = None

    def add_done_callback(self, callback: Callable[['Future'], None]) -> None:
        self._callbacks.append(callback)

    def respond(self, response: object) -> None:
        self._response = response
        for callback in list(self._callbacks):
            callback(self)

    def result(self) -> object:
        return self._response

    def forget(self) -> None:
        self._callbacks.clear()


class Client:
    """A client of one service."""

    def __init__(self, graph: 'Graph', service: str) -> None:
        self._graph = graph
        self._service = service

    def service_is_ready(self) -> bool:
        is_connected = self._service not in self._graph.unconnected
        return is_connected and self._graph.service_is_ready()

    def call_async(self, message: Any) -> Future:
        future = Future(message)
        self._graph.sent.append(future)
        self._graph.calls.append((self._service, future))
        return future

    def remove_pending_request(self, future: Future) -> None:
        future.forget()


class Graph:
    """A node of ROS, and what it sees."""

    def __init__(self) -> None:
        self.servers: list[int] = []
        self.tells_servers = True
        self.is_ready: bool | None = None
        #: The services that are not connected yet, by the ends of their names.
        self.unconnected: set[str] = set()
        self.sent: list[Future] = []
        #: The same, each with its service.
        self.calls: list[tuple[str, Future]] = []

    def create_client(self, kind: object, name: str) -> Client:
        return Client(self, name.rpartition('/')[2])

    def get_publishers_info_by_topic(self, topic: str, **_: bool) -> list[Any]:
        assert topic.startswith('rr/')
        servers = self.servers if self.tells_servers else []
        return [SimpleNamespace(endpoint_gid=[one]) for one in servers]

    def service_is_ready(self) -> bool:
        return bool(self.servers) if self.is_ready is None else self.is_ready
