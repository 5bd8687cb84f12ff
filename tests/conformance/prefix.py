# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The installed packages that the conformance cases name."""

from pathlib import Path
import shutil
import sys
import sysconfig

HERE = Path(__file__).parent
#: The packages and their programs, each of which is the probe.
PROGRAMS = {
    'alpha': ('talker', 'listener'),
    'beta': ('driver',),
    'gamma-pkg': ('tool.py',),
    'fakepkg': ('argv', 'noop', 'slp'),
}
#: A file in the program folder of `alpha` that may not be executed.
NOT_EXECUTABLE = 'not_executable'

_MANIFEST = """\
<package format="3">
  <name>{name}</name>
  <version>1.0.0</version>
  <description>A package of the conformance cases.</description>
  <maintainer email="nobody@example.com">nobody</maintainer>
  <license>Apache-2.0</license>
</package>
"""


def install_packages(prefix: Path) -> None:
    """Lay out the packages as an installation of ROS 2 has them."""
    shutil.copytree(HERE / 'installed', prefix)
    for package, programs in PROGRAMS.items():
        _register(prefix, package)
        for program in programs:
            _install_probe(prefix / 'lib' / package / program)
    (prefix / 'lib' / 'alpha' / NOT_EXECUTABLE).write_text('#!/bin/sh\n')
    _install_probe(prefix / 'bin' / 'probe')


def _register(prefix: Path, package: str) -> None:
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True, exist_ok=True)
    (index / package).touch()
    share = prefix / 'share' / package
    share.mkdir(parents=True, exist_ok=True)
    (share / 'package.xml').write_text(_MANIFEST.format(name=package))


def _install_probe(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    probe = (HERE / 'probe.py').read_text(encoding='utf-8')
    # what `site` imports takes longer than all else
    packages = sysconfig.get_path('purelib')
    head = f'#!{sys.executable} -S\nimport sys\n'
    head += f'sys.path.append({packages!r})\n'
    path.write_text(head + probe, encoding='utf-8')
    path.chmod(0o755)
