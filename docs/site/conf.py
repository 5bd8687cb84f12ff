# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
The site that `make docs` builds with Sphinx.

Its sources are the documents of the whole repository, so that their links
lead to the same places as on GitHub. The navigation is made from
docs/README.md, which lists all pages.
"""

from pathlib import Path
import posixpath
import re

from colcon_yamllaunch import __version__
from sphinx.application import Sphinx

project = 'colcon-yamllaunch'
author = 'The colcon-yamllaunch authors'
project_copyright = f'2026, {author}'
release = version = __version__

extensions = ['myst_parser', 'sphinx.ext.autodoc']
include_patterns = ['*.md', 'docs/*.md', 'sample_ws/README.md']
exclude_patterns = ['.*', 'build', 'sample_ws/*/**', 'tests']
root_doc = 'README'

# anchors as on GitHub, and an id in the middle of a line
myst_heading_anchors = 4
myst_enable_extensions = ['attrs_inline']

add_module_names = False
autodoc_inherit_docstrings = False
autodoc_member_order = 'bysource'
# `text` in a docstring is code
default_role = 'code'

html_theme = 'furo'
html_title = f'{project} {release}'
html_copy_source = False
html_extra_path = ['index.html']


def setup(app: Sphinx) -> None:
    """Adapt each document when it is read."""
    app.connect('source-read', _adapt)


def _adapt(app: Sphinx, document: str, source: list[str]) -> None:
    if document == root_doc:
        source[0] += _contents(Path(app.srcdir) / 'docs/README.md')
    # MyST does not look for anchors in HTML
    source[0] = re.sub(r'<a id="([^"]+)"></a>', r'[]{#\1}', source[0])


def _contents(index: Path) -> str:
    """Return a toctree for each section of `index`, and one with itself."""
    _, *parts = re.split(
        r'^## (.+)$', index.read_text(encoding='utf-8'), flags=re.MULTILINE
    )
    sections = [('Documentation', '[](README.md)')]
    sections += zip(parts[::2], parts[1::2], strict=True)
    text = ''
    for title, links in sections:
        text += f'\n```{{toctree}}\n:hidden:\n:caption: {title}\n\n'
        for link in re.findall(r'\]\((\S+)\.md\)', links):
            text += '/' + posixpath.normpath(f'docs/{link}') + '\n'
        text += '```\n'
    return text
