# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The program that builds on the machine, run by the Python of its colcon.

It decides as a launch there does, and uses the same records.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
import json
import logging
import os
from pathlib import Path
import re
import signal
import sys
from typing import Any

from colcon_yamllaunch.common.adoption import end_with_parent
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.workspace.building.build_lock import WorkspaceLock
from colcon_yamllaunch.workspace.building.build_processes import interruption
from colcon_yamllaunch.workspace.building.update import (
    bring_up_to_date,
    BuildRequest,
)
from colcon_yamllaunch.workspace.environment.sourcing import (
    build_environment,
    chained_underlays,
    Environment,
    source,
    sourced_underlays,
)
from colcon_yamllaunch.workspace.packages.package import invalid_manifest
from colcon_yamllaunch.workspace.packages.workspace_root import Trust

#: Where ROS 2 is installed by packages of the system.
_ROS = Path('/opt/ros')


class _HeldLock(WorkspaceLock):
    """The lock of the workspace, which another process holds; see `build`."""

    def acquire(
        self,
        build_base: Path,  # noqa: ARG002
        announce: Callable[[str], None],  # noqa: ARG002
    ) -> bool:
        return False


def main() -> int:
    """
    Build; write the output to stderr, and the result to stdout, as JSON.

    The argument is the request, as JSON: `root`; `needed`, the names of the
    packages; `arguments`, those of `colcon build`; `here`, `underlays` and
    `distro`, the root, the underlays and the ROS 2 of the workspace that the
    code comes from; and `parent`, the process id of our parent, whose end
    stops the build. The result has the `built` packages, or an `error`.
    """
    request = json.loads(sys.argv[1])
    result = os.dup(1)
    os.dup2(2, 1)
    try:
        end_with_parent(signal.SIGTERM, request['parent'])
        answer = _build(request)
    except UserError as e:
        answer = {'error': str(e)}
    except ImportError as e:
        answer = {
            'error': f'the colcon there, of {sys.executable}, cannot be used: '
            f"{e}. Install it anew, with 'colcon-common-extensions'"
        }
    with suppress(OSError), open(result, 'wb') as file:
        file.write(json.dumps(answer).encode())
    return 0


def _build(request: Mapping[str, Any]) -> dict[str, Any]:
    # these import colcon
    from colcon_yamllaunch.workspace.colcon.colcon_adapter import set_up_colcon
    from colcon_yamllaunch.workspace.colcon.colcon_cache import CachedColcon

    # colcon finds the extensions of a colcon-yamllaunch that is installed
    # there, and this one, which is in its place, has none
    logger = logging.getLogger('colcon.colcon_core.extension_point')
    logger.addFilter(lambda r: "'colcon_yamllaunch." not in r.getMessage())
    set_up_colcon()
    root = Path(request['root'])
    needed = frozenset(request['needed'])
    # the arguments may name the root of the other workspace
    here = re.compile(re.escape(request['here']) + r'(?![\w.-])')
    colcon = CachedColcon(
        root, [here.sub(lambda _: str(root), w) for w in request['arguments']]
    )
    Trust(os.environ).check(
        colcon.root, colcon.build_base, colcon.install_base
    )
    packages = colcon.packages()
    unknown = needed.difference(package.name for package in packages)
    if unknown:
        raise UserError(
            f'the colcon there does not find {", ".join(sorted(unknown))} '
            f'below {root}: is there a COLCON_IGNORE in a folder above it, '
            'or an argument that passes it over?'
        )
    for package in packages:
        reason = invalid_manifest(package) if package.name in needed else None
        if reason is not None:
            raise UserError(reason)
    environment = _environment(request, colcon.install_base)
    with interruption() as interrupted:
        update = bring_up_to_date(
            colcon,
            BuildRequest(needed),
            environment,
            _say,
            lock=_HeldLock(),
        )
    if interrupted.returncode is not None:
        update = replace(update, returncode=interrupted.returncode)
    sys.stdout.flush()
    if update.returncode:
        raise UserError(f'the build failed there: {update.failure()}')
    return {'built': sorted(update.built)}


def _environment(
    request: Mapping[str, Any], install_base: Path
) -> Environment:
    """
    Return the environment of the build.

    A machine that is reached by ssh has sourced nothing. The underlays are
    those that the workspace was built on top of, or else those of the
    workspace that the code comes from, or ROS 2 itself.
    """
    environment: Mapping[str, str] = dict(os.environ) | {'COLCON': '1'}
    if chained_underlays(install_base) or sourced_underlays(
        environment, install_base
    ):
        return build_environment(environment, install_base)
    scripts = [Path(path, 'local_setup.bash') for path in request['underlays']]
    scripts = [script for script in scripts if script.is_file()]
    if not scripts:
        known = sorted(_ROS.glob('*/local_setup.bash'))
        named = [s for s in known if s.parent.name == request['distro']]
        scripts = named or (known if len(known) == 1 else [])
    for script in scripts:
        environment = source(script, environment).variables
    if not scripts:
        return Environment(environment)
    used = ', '.join(str(script.parent) for script in scripts)
    return Environment(environment, notes=(f'building on top of {used}',))


def _say(line: str) -> None:
    print(line, flush=True)
