# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The setup scripts whose behaviour is known.

colcon and ament write them from templates. A script counts as known when it
is, but for the values that were filled in, character for character one of the
versions listed here, so that another version is never taken for one of these.
"""

import os
import re

from colcon_yamllaunch.common.digest import digest
from colcon_yamllaunch.common.frozen import dataclass

#: colcon-bash 0.5.0, shell/template/prefix_chain.bash.em
_SETUP_BASH = 'e04c147116b44f9a2af8143bf61376b7'
#: colcon-bash 0.5.0, shell/template/prefix.bash.em
_LOCAL_SETUP_BASH = '0cb5b16cb3b371efa8f56d57e45fb662'
#: colcon-core 0.7.0 to 0.21.3, shell/template/prefix_util.py.em
_PREFIX_UTIL = frozenset(
    (
        '94d97ad06be35da77e0e96b077c18ed4',
        'e3ec70ec4d9ed25cdcca373d0a167d6b',
        '55f770ee9b59c0317801393ad8d6b1fe',
        '689680e9e8f813046fa1316da6c412e5',
        'b279dd008e4e97450f52797eea2a5347',
        '2b16babf6f533a4258e744fd78572ee0',
    )
)
#: ament_package from 0.10.0, template/prefix_level/local_setup.bash
_AMENT_LOCAL_SETUP_BASH = 'fcc616a65d40ee6313801eefe7838f46'
#: ament_package from 0.10.0, template/prefix_level/local_setup.sh.in
_AMENT_LOCAL_SETUP_SH = 'daf97ec421e2083474c5d534a6d08462'
#: ament_package from 0.9.0, template/prefix_level/_local_setup_util.py
_AMENT_PREFIX_UTIL = frozenset(
    (
        '9c3b2b35a00fe7e9a8859478a2933d91',
        'c3ec3bef77ac503250639819e9debd0d',
        '5667bf28c8ad4713964d3e709901522c',
        'ad066871df0cf764e88a581535cefb64',
        'e647c83debc8355ed7955cc960474a16',
    )
)

#: A value that a shell leaves as it is, within double quotes.
_LITERAL = r'[^"$`\\\n]*'
#: A command that is not quoted.
_COMMAND = r'[\w./+@:,%=-]+'
_CHAIN_HEADING = '\n# source chained prefixes\n'
_CHAINED = re.compile(
    r'^# setting COLCON_CURRENT_PREFIX avoids determining the prefix in the '
    r'sourced script\n'
    rf'COLCON_CURRENT_PREFIX="({_LITERAL})"\n'
    r'_colcon_prefix_chain_bash_source_script '
    r'"\$COLCON_CURRENT_PREFIX/local_setup\.bash"\n',
    re.M,
)
_PYTHON = re.compile(
    rf'^( *_(?:colcon|ament)_python_executable)="({_COMMAND})"$', re.M
)
_WORD = re.compile(r'[\w.:\[-]+')
_COMMENT = re.compile(r'^ *#.*$', re.M)
_MERGED = ' --merged-install)"'
_AMENT_PREFIX = re.compile(
    rf'^(_ament_prefix_sh_AMENT_CURRENT_PREFIX)="{_LITERAL}"$', re.M
)


@dataclass(frozen=True, slots=True)
class PrefixScript:
    """
    A script that sources the packages of one prefix.

    :param python: The Python that was filled in
    :param merge_install: Whether all packages are installed into one prefix
    """

    python: str
    merge_install: bool


def chained_prefixes(setup_bash: str) -> list[str] | None:
    """
    Read colcon's setup.bash.

    :param setup_bash: The content of the script
    :returns: The prefixes that it sources first, in this order, or None when
      the script is not known
    """
    text = _CHAINED.sub('', setup_bash).replace(_CHAIN_HEADING, '')
    if _digest(text) != _SETUP_BASH:
        return None
    return _CHAINED.findall(setup_bash)


def colcon_prefix_script(local_setup_bash: str) -> PrefixScript | None:
    """
    Read colcon's local_setup.bash.

    :param local_setup_bash: The content of the script
    :returns: What was filled in, or None when the script is not known
    """
    text, python = _without_python(local_setup_bash)
    merged = _MERGED in text
    text = text.replace(_MERGED, ')"')
    if python is None or _digest(text) != _LOCAL_SETUP_BASH:
        return None
    return PrefixScript(python, merged)


def is_colcon_prefix_util(text: str) -> bool:
    """Tell whether a content is that of a known _local_setup_util_sh.py."""
    return _digest(text) in _PREFIX_UTIL


def is_ament_bash_script(text: str) -> bool:
    """Tell whether a content is that of ament's local_setup.bash."""
    return _digest(text) == _AMENT_LOCAL_SETUP_BASH


def ament_prefix_script(local_setup_sh: str) -> PrefixScript | None:
    """
    Read ament's local_setup.sh, as in /opt/ros.

    :param local_setup_sh: The content of the script
    :returns: What was filled in, or None when the script is not known
    """
    text, python = _without_python(local_setup_sh)
    text = _AMENT_PREFIX.sub(r'\1', text)
    if python is None or _digest(text) != _AMENT_LOCAL_SETUP_SH:
        return None
    return PrefixScript(python, merge_install=True)


def is_ament_prefix_util(text: str) -> bool:
    """Tell whether a content is that of a known _local_setup_util.py."""
    return _digest(text) in _AMENT_PREFIX_UTIL


def commands(text: str) -> set[str]:
    """Get the words of a script, the names of its commands among them."""
    return set(_WORD.findall(_COMMENT.sub('', text)))


def _without_python(text: str) -> tuple[str, str | None]:
    found = _PYTHON.search(text)
    if found is None:
        return text, None
    return _PYTHON.sub(r'\1', text, count=1), found[2]


def _digest(text: str) -> str:
    return digest(os.fsencode(text))
