# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The files, packages and system of the machine. Runs there.

The launcher checks the files that a part names, finds the packages of
`sync: none`, and compares contents for `--watch`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
import os
from pathlib import Path
import platform
import re
import subprocess
from typing import Any

from colcon_yamllaunch.common.errors import UserError, WorkspaceError
from colcon_yamllaunch.common.files import content_of, split_path
from colcon_yamllaunch.common.fingerprint import (
    content_digest,
    digest,
    Fingerprint,
    fingerprint,
)
from colcon_yamllaunch.plan.labels import ANY_PACKAGE
from colcon_yamllaunch.workspace.environment.environment_cache import (
    cached_environment,
)
from colcon_yamllaunch.workspace.freshness.build_record import (
    DamagedRecordError,
    read_record,
    RECORD_NAME,
)
from colcon_yamllaunch.workspace.freshness.source_changes import tree

Say = Callable[[str], None]
_VERSION = re.compile(rb'<version\b[^>]*>\s*([^<\s]+)\s*</version>')
_MARKERS = (
    'share/{}/package.xml',
    'share/colcon-core/packages/{}',
    'share/ament_index/resource_index/packages/{}',
)
_LINK = 'link to '
_PYTHON_TIMEOUT = 10.0


def find_missing(arguments: Mapping[str, Any], _say: Say) -> dict[str, Any]:
    """
    Return the paths without a file or folder, as `missing`.

    :param arguments: `paths`, absolute or with a leading `~/`
    """
    exists = {
        path: os.path.exists(os.path.expanduser(path))
        for path in arguments['paths']
    }
    return {'missing': [path for path in exists if not exists[path]]}


def find_limit_problems(
    arguments: Mapping[str, Any], _say: Say
) -> dict[str, Any]:
    """
    Return which limits of processes cannot be set here, as `problems`.

    Each has the label of a process, the key of the limit, the problem and the
    hint or null.

    :param arguments: `plan`, a plan with these processes as JSON
    """
    # few launches have limits
    from colcon_yamllaunch.engine.resource_limits import problems_of
    from colcon_yamllaunch.plan.plan_json import plan_from_json

    plan = plan_from_json(arguments['plan'])
    return {
        'problems': [
            [found.label, found.key, found.problem, found.hint]
            for found in problems_of(plan.processes(), os.environ)
        ]
    }


def find_packages(arguments: Mapping[str, Any], say: Say) -> dict[str, Any]:
    """
    Find packages in the environment of the workspace.

    The arguments are `workspace`, its root; `install_base` and `build_base`,
    relative to it; and `names`. Return the digest and the version of the
    manifest of each package that was `found`, both empty without a manifest;
    and the `prefixes` that were searched.
    """
    root = Path(os.path.realpath(Path(arguments['workspace']).expanduser()))
    install_base = root / arguments['install_base']
    names = list(arguments['names'])
    prefixes = [install_base, *(install_base / name for name in names)]
    found = {n: m for n in names if (m := _manifest(n, prefixes)) is not None}
    missing = [name for name in names if name not in found]
    if missing:
        variables: Mapping[str, str] = os.environ
        setup = install_base / 'setup.bash'
        if setup.is_file():
            try:
                variables = cached_environment(
                    setup, os.environ, root / arguments['build_base']
                ).variables
            except WorkspaceError as e:
                say(str(e))
        prefixes += [
            Path(path)
            for name in ('AMENT_PREFIX_PATH', 'COLCON_PREFIX_PATH')
            for path in split_path(variables.get(name))
        ]
        for name in missing:
            manifest = _manifest(name, prefixes)
            if manifest is not None:
                found[name] = manifest
    shown = [str(p) for p in dict.fromkeys(prefixes) if p.is_dir()]
    return {'found': found, 'prefixes': shown}


def version_of(manifest: bytes) -> str:
    """Return the version of a manifest, empty if it has none."""
    match = _VERSION.search(manifest)
    return match[1].decode(errors='replace') if match else ''


def _manifest(name: str, prefixes: list[Path]) -> list[str] | None:
    for prefix in prefixes:
        for marker in _MARKERS:
            path = prefix / marker.format(name)
            if not path.is_file():
                continue
            with suppress(OSError):
                content = content_of(prefix / _MARKERS[0].format(name))
                return [digest(content), version_of(content)]
            return ['', '']
    return None


def read_contents(arguments: Mapping[str, Any], _say: Say) -> dict[str, Any]:
    """
    Return texts that change with the contents of packages and files.

    Each package in `packages` has `installed` and `products`: the texts by
    paths relative to the install space and to its folder below `build/`, also
    of files behind links. The packages of a merged install space without
    records of their builds are one, `ANY_PACKAGE`. Each file in `files` has
    its text, empty if there is no file.

    :param arguments: `packages`, their names; if there are any, `build_base`,
      `install_base` and `merge_install`; and `files`; paths may begin with
      `~/`
    """
    packages: dict[str, Any] = {}
    for name in arguments['packages']:
        install_base, build_base = (
            Path(os.path.expanduser(arguments[base]))
            for base in ('install_base', 'build_base')
        )
        merged = arguments['merge_install']
        record = None
        with suppress(DamagedRecordError):
            record = read_record(build_base / name / RECORD_NAME)
        if record is not None:
            installed, built = record.installed, record.products
        else:
            # it was sent after it was built, or somebody else built it
            paths = tree(install_base if merged else install_base / name)
            unknown = Fingerprint(0, 0, executable=False)
            installed = {
                os.path.relpath(p, install_base): unknown for p in paths
            }
            built = {}
        shown = ANY_PACKAGE if merged and record is None else name
        packages[shown] = {
            'installed': dict(_contents(install_base, installed)),
            'products': dict(_contents(build_base / name, built)),
        }
    return {
        'packages': packages,
        'files': {
            path: _content(os.path.expanduser(path))
            for path in arguments['files']
        },
    }


def _contents(
    base: Path, files: Mapping[str, Fingerprint]
) -> Iterator[tuple[str, str]]:
    for path, found in files.items():
        if found.digest and not found.digest.startswith(_LINK):
            yield path, f'{found.digest} {found.executable:d}'
            continue
        # the target of a link may change without a build
        yield path, _content(f'{base}/{path}')
        for below in tree(base / path):
            inner = os.path.relpath(below, base)
            yield inner, _content(f'{base}/{inner}')


def _content(path: str) -> str:
    """Return a text that changes with a file; empty if there is none."""
    now = fingerprint(path)
    if now is None or not os.path.isfile(path):
        return ''
    # large files, and those that cannot be read, are known by their times
    content = content_digest(Path(path), now.size) or f'{now.size} {now.mtime}'
    return f'{content} {now.executable:d}'


def system() -> dict[str, str]:
    """Return the properties that compiled programs and modules depend on."""
    name = os.uname().sysname
    with suppress(OSError):
        values = platform.freedesktop_os_release()
        name = ' '.join(filter(None, (values['ID'], values.get('VERSION_ID'))))
    program = 'import sys; print("%d.%d" % sys.version_info[:2])'
    words = ['python3', '-I', '-S', '-c', program]
    return {
        'system': name,
        'architecture': platform.machine(),
        'glibc': platform.libc_ver()[1],
        # that of the Python that programs get, as `3.12`
        'python': _last_line(words, _PYTHON_TIMEOUT).strip(),
    }


def login_shell_line(command: str, timeout: float) -> str:
    """
    Return the last line that a command prints in the user's login shell.

    It is empty if the command fails.

    :param timeout: How long the shell may take, in seconds
    """
    shell = os.environ.get('SHELL') or '/bin/sh'
    return _last_line([shell, '-lc', command], timeout)


def _last_line(words: Sequence[str], timeout: float) -> str:
    with suppress(OSError, subprocess.SubprocessError):
        printed = subprocess.run(
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=timeout,
        ).stdout
        return (os.fsdecode(printed).splitlines() or [''])[-1]
    return ''


def check_system(
    built_on: Mapping[str, str],
    pythons: Sequence[str],
    underlays: Sequence[str],
) -> None:
    """
    Check that code that was built elsewhere runs here.

    :param built_on: The result of :func:`system` where it was built
    :param pythons: The versions of Python that modules are installed for
    :param underlays: The prefixes that it was built on top of
    :raises UserError: when it does not
    """
    ours = system()
    what = 'what is built here is'
    for key, verb in (('architecture', 'is'), ('system', 'runs')):
        if built_on[key] != ours[key]:
            found = ours[key] or 'unknown'
            raise _unfit(f'it {verb} {found}', what, built_on[key])
    if _numbers(ours['glibc']) < _numbers(built_on['glibc']):
        its = f'its C library is glibc {ours["glibc"] or "of no version"}'
        raise _unfit(its, what, built_on['glibc'])
    if pythons and ours['python'] not in pythons:
        what = 'modules are built here'
        its = f'its python3 is {ours["python"] or "missing"}'
        raise _unfit(its, what, ' and '.join(pythons))
    for underlay in underlays:
        if not Path(underlay, 'local_setup.bash').is_file():
            raise UserError(
                f'what is built here needs {underlay}, which is not there: '
                'install it there, or build there by `sync: build`'
            )


def _unfit(its: str, what: str, wanted: str) -> UserError:
    return UserError(
        f'{its}, and {what} for {wanted}: build there instead, by '
        '`sync: build`'
    )


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(map(int, re.findall(r'\d+', version)))
