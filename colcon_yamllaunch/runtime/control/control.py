# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The ways by which a running launch is looked at and acted on."""

from collections.abc import Callable
from collections.abc import Mapping
from pathlib import Path

from colcon_yamllaunch.runtime.control.launch_states import About
from colcon_yamllaunch.runtime.control.local_attachment import LocalAttachment
from colcon_yamllaunch.runtime.control.server import Server
from colcon_yamllaunch.runtime.control.service import Service
from colcon_yamllaunch.runtime.control.socket_address import Address
from colcon_yamllaunch.runtime.control.socket_folder import FolderError
from colcon_yamllaunch.runtime.core.events import Warned
from colcon_yamllaunch.runtime.course.engine import Engine
from colcon_yamllaunch.runtime.stopping.guard_link import GuardLink


class Control:
    """
    The socket and the keyboard of a launch.

    :param engine: Runs it
    :param attachment: The keyboard, if it is attached to a process
    """

    def __init__(
        self, engine: Engine, attachment: LocalAttachment | None
    ) -> None:
        self._engine = engine
        self._attachment = attachment
        self._server: Server | None = None
        if attachment is not None:
            attachment.connect(engine)

    def serve(
        self,
        about: About,
        environment: Mapping[str, str],
        guard: GuardLink,
        log_folder: Path | None,
        log_files: Mapping[str, Path],
        clock: Callable[[], float],
    ) -> None:
        """
        Let other terminals of the user look at the launch.

        Where that cannot be, it is said, and the launch goes on.

        :param about: What the launch is known by
        :param environment: The user's environment
        :param guard: Removes the socket of a launch that is killed
        :param log_folder: The folder with its logs, if it writes any
        :param log_files: For each label the log with all output
        :param clock: Returns the time in seconds
        """
        engine = self._engine
        try:
            address = Address(environment)
        except (OSError, FolderError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            engine.tell(
                Warned(
                    f'other terminals cannot see this launch: {reason}; '
                    '`colcon launch --status` will not list it'
                )
            )
            return
        guard.socket(address.path)
        service = Service(
            about,
            engine.supervisor,
            engine.terminals,
            log_folder,
            log_files,
            engine.tell,
            clock,
        )
        engine.listen(service.handle)
        self._server = Server(address, engine.watches, service)

    def close(self) -> None:
        """Send everybody away, and give the keyboard back as it was."""
        if self._attachment is not None:
            self._attachment.close()
        if self._server is not None:
            self._server.close()
