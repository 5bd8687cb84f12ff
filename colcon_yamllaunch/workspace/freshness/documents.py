# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Documents in a package's source that no CMake file takes in.

Only what people read where it lies counts as a document, and only where no
word in the CMake files may mean it: its name, a pattern that fits, a folder
that it is in. In doubt it is a file like any other.
"""

from collections.abc import Iterable
from fnmatch import fnmatchcase
import re

#: Where documents are, relative to the package.
_FOLDERS = ('', 'doc', 'docs')
_NAMES = re.compile(
    r'(readme|license|licence|copying|notice|authors|contributors|changelog'
    r'|changes|history|contributing|code_of_conduct|security'
    r'|quality_declaration)(\.\w+)?|[^.].*\.(md|rst)',
    re.IGNORECASE,
)
#: What runs programs, which may read whatever they like.
_PROGRAMS = re.compile(
    r'\b(execute_process|exec_program|add_custom_\w+|externalproject_\w+'
    r'|fetchcontent_\w+|try_run)\s*\(',
    re.IGNORECASE,
)
_COMMENT = re.compile(r'^\s*#.*$', re.MULTILINE)
#: Where something is installed to.
_DESTINATION = re.compile(r'\bDESTINATION\s+\S+')
_SEPARATORS = re.compile(r'[\s"\'();<>:=]+')
_VARIABLE = re.compile(r'\$\w*\{[^{}]*\}')
#: The folder of the source itself, or the one around it.
_WHOLE = re.compile(
    r'(\.{1,2}|\$\{\w*(SOURCE_DIR|LIST_DIR|HOME_DIRECTORY)\})[./]*'
)


def is_document(relative: str) -> bool:
    """
    Tell whether a file is one that people read and tools do not.

    :param relative: Its path in the package
    """
    folder, _, name = relative.rpartition('/')
    return folder in _FOLDERS and _NAMES.fullmatch(name) is not None


def may_be_meant(relative: str, texts: Iterable[str]) -> bool:
    """
    Tell whether CMake files may read or install a file of the source.

    :param texts: Their texts
    """
    parts = [part.lower() for part in relative.split('/')]
    # a name may be put together from its parts
    parts += [part.partition('.')[0] for part in parts]
    for text in texts:
        if _PROGRAMS.search(text):
            return True
        text = _DESTINATION.sub('', _COMMENT.sub('', text))
        if any(_means(word, parts) for word in _SEPARATORS.split(text)):
            return True
    return False


def _means(word: str, parts: list[str]) -> bool:
    if _WHOLE.fullmatch(word):
        return True
    name = word.rstrip('/').rpartition('/')[2].lower()
    if not _VARIABLE.sub('', name):
        # what the variables are made of stands elsewhere
        return False
    pattern = _VARIABLE.sub('*', name)
    return any(fnmatchcase(part, pattern) for part in parts)
