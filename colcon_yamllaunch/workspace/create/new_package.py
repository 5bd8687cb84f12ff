# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Making a package.

What a package should be called says REP 144. catkin_pkg lets more pass, and
so do we, with a warning; what no tool could work with is an error.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import keyword
from pathlib import Path
import re
import shutil
import sys
import time
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from colcon_core.shell.template import expand_template
from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.frozen import dataclass
from colcon_yamllaunch.workspace.packages.package import manifest_error

_PACKAGE = re.compile(r'[a-zA-Z][a-zA-Z0-9_-]*')
_NODE = re.compile(r'[a-zA-Z][a-zA-Z0-9_]*')
#: Names that CMake (policy CMP0037) and ament_cmake keep for themselves.
_CMAKE_TARGETS = {
    *('all', 'clean', 'depend', 'edit_cache', 'help', 'install'),
    *('package', 'rebuild_cache', 'test', 'uninstall'),
}
#: The licenses, as SPDX calls them, whose texts are known.
LICENSES = ('Apache-2.0', 'BSD-3-Clause', 'MIT')
#: What `ros2 pkg create` writes where no license was chosen, too: tools that
#: release packages know it.
NO_LICENSE = 'TODO: License declaration'
_TEMPLATES = Path(__file__).parent / 'template'


def check_package_name(name: str, build_type: str) -> None:
    """
    Check that a package may have a name.

    :param build_type: Such as `ament_python`
    :raises UserError: when it may not
    """
    if not _PACKAGE.fullmatch(name):
        raise UserError(
            f"'{name}' is no name for a package",
            'REP 144 asks for lower case letters, digits and underscores, and '
            'a letter first',
        )
    module = module_name(name)
    if keyword.iskeyword(module):
        raise UserError(
            f"'{name}' is no name for a package: it is a reserved word of "
            'Python, so its Python modules could not be imported'
        )
    if build_type == 'ament_python' and module in sys.stdlib_module_names:
        raise UserError(
            f"'{name}' is no name for a Python package: Python has a module "
            'of this name itself'
        )


def dislikes(name: str) -> Iterator[str]:
    """Iterate over what REP 144 has against a name that works all the same."""
    if name != name.lower():
        yield 'lower case letters only'
    if '-' in name:
        yield "underscores in place of '-'"
    if '__' in name:
        yield 'no underscores in a row'
    if len(name) < 2:
        yield 'at least two characters'


def advised_name(name: str) -> str:
    """Return a name as REP 144 asks for, made of another one."""
    words = re.sub(r'(?<=[a-z0-9])(?=[A-Z])', '_', name)
    return re.sub(r'[-_]+', '_', words).strip('_').lower()


def check_node_name(name: str, build_type: str, is_cpp: bool = False) -> None:
    """
    Check that a node, and so its Python module or program, may have a name.

    :param build_type: Such as `ament_python`
    :param is_cpp: Whether it is written in C++
    :raises UserError: when it may not
    """
    if not _NODE.fullmatch(name):
        raise UserError(
            f"'{name}' is no name for a node",
            'it consists of letters, digits and underscores, with a letter '
            'first',
        )
    if is_cpp:
        if name in _CMAKE_TARGETS:
            raise UserError(
                f"'{name}' is no name for a node written in C++: CMake has a "
                'target of this name itself'
            )
        return
    if keyword.iskeyword(name) or keyword.iskeyword(class_name(name)):
        raise UserError(
            f"'{name}' is no name for a node written in Python: it is a "
            'reserved word there'
        )
    hidden = sys.stdlib_module_names | {'rclpy'}
    if build_type != 'ament_python' and name in hidden:
        raise UserError(
            f"'{name}' is no name for a node here: scripts/{name}.py would "
            f"hide Python's own module '{name}' from itself"
        )


def default_node_name(package: str) -> str:
    """Return the name of a package's node when none is given."""
    name = module_name(package)
    return name if name.endswith('_node') else f'{name}_node'


def module_name(package: str) -> str:
    """Return the name of a package's Python module."""
    return package.replace('-', '_')


def class_name(node: str) -> str:
    """Return the name of the class of a node."""
    words = node.split('_')
    return ''.join(word[:1].upper() + word[1:] for word in words)


@dataclass(frozen=True, slots=True)
class NewPackage:
    """
    A package that is to be made.

    :param build_type: `ament_cmake`, `ament_python` or `cmake`
    :param node: The name of its node
    :param is_cpp: Whether that is written in C++; else it is in Python
    :param dependencies: The packages that it needs to be built and to run
    :param license: Such as `MIT`, by SPDX
    """

    name: str
    build_type: str
    node: str
    is_cpp: bool
    maintainer_name: str
    maintainer_email: str
    dependencies: tuple[str, ...]
    license: str
    description: str

    @property
    def is_ros(self) -> bool:
        """Whether its node is one of ROS."""
        return client_library(self.is_cpp) in self.dependencies

    @property
    def executable(self) -> str:
        """The name by which its node is run and launched."""
        is_script = self.build_type != 'ament_python' and not self.is_cpp
        suffix = '.py' if is_script else ''
        return f'{self.node}{suffix}'

    @property
    def launch_file(self) -> str:
        """The name of its launch file."""
        return f'{self.name}.launch.yaml'

    def files(self) -> dict[str, str]:
        """
        Return for each file, by its path in the package, its template.

        The template of an empty file is empty.
        """
        node = node_template(is_ros=self.is_ros, is_cpp=self.is_cpp)
        files = {'package.xml': 'package.xml'}
        if self.is_cpp or self.build_type != 'ament_python':
            place = 'src/{}.cpp' if self.is_cpp else 'scripts/{}.py'
            files['CMakeLists.txt'] = 'CMakeLists.txt'
            files[place.format(self.node)] = node
        else:
            module = module_name(self.name)
            files |= {
                'setup.py': 'setup.py',
                'setup.cfg': 'setup.cfg',
                f'resource/{self.name}': '',
                f'{module}/__init__.py': '',
                f'{module}/{self.node}.py': node,
            }
        files[f'launch/{self.launch_file}'] = 'launch.yaml'
        if self.is_ros:
            files[f'config/{self.name}.yaml'] = 'parameters.yaml'
        else:
            files[f'config/{self.name}.ini'] = 'settings.ini'
        if not self.is_cpp:
            files[f'test/test_{self.node}.py'] = 'test_node.py'
        if self.license in LICENSES:
            files['LICENSE'] = f'license_{self.license}'
        return files


def node_template(*, is_ros: bool, is_cpp: bool) -> str:
    """Return the template of the code of a node."""
    return f'{"ros" if is_ros else "plain"}_node.{"cpp" if is_cpp else "py"}'


def client_library(is_cpp: bool) -> str:
    """Return the package of ROS 2 that nodes are written with."""
    return 'rclcpp' if is_cpp else 'rclpy'


def make_package(package: NewPackage, folder: Path) -> None:
    """
    Write all files of a package.

    :param folder: Where to; it must not be there yet
    :raises UserError: when it is there, cannot be written or would be
      invalid; then nothing is left of it
    """
    with new_folder(folder):
        values = _values(package)
        for path, template in package.files().items():
            write_file(folder / path, template, values)
        reason = manifest_error(folder)
        if reason is not None:
            # catkin_pkg names the file, which will not be there
            reason = reason.rpartition("package.xml': ")[2]
            raise UserError(f'package.xml would be invalid: {reason}')


@contextmanager
def new_folder(folder: Path, other: str | None = None) -> Iterator[None]:
    """
    Make a folder, and remove it if it cannot be filled.

    :param other: What the user can do if it is there already
    :raises UserError: when it is there already or cannot be written
    """
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir()
    except FileExistsError as e:
        raise UserError(
            f'{e.filename} is there already: nothing was written', other
        ) from e
    except OSError as e:
        raise UserError(f'cannot make {folder}: {e.strerror}') from e
    try:
        yield
    except OSError as e:
        shutil.rmtree(folder)
        raise UserError(f'cannot write {folder}: {e.strerror}') from e
    except BaseException:
        shutil.rmtree(folder)
        raise


def write_file(file: Path, template: str, values: Mapping[str, Any]) -> None:
    """
    Make a file of a template, executable if it is in a folder of scripts.

    :param template: The name of the template; empty for an empty file
    :raises OSError: when the file cannot be written
    """
    if template:
        path = _TEMPLATES / f'{template}.em'
        expand_template(path, file, dict(values))
    else:
        file.parent.mkdir(exist_ok=True)
        file.touch()
    if file.parent.name == 'scripts':
        make_executable(file)


def make_executable(file: Path) -> None:
    """Let everyone run a file who may read it."""
    mode = file.stat().st_mode
    file.chmod(mode | (mode & 0o444) >> 2)


def _values(package: NewPackage) -> Mapping[str, Any]:
    fields = {name: getattr(package, name) for name in package.__slots__}
    return fields | {
        'class_name': class_name(package.node),
        'executable': package.executable,
        'is_ros': package.is_ros,
        'is_script': package.build_type != 'ament_python',
        'module': module_name(package.name),
        'xml': escape,
        'xml_attribute': quoteattr,
        'year': time.strftime('%Y'),
    }
