# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Links within the repository's documents lead somewhere."""

from pathlib import Path
import re

import pytest

ROOT = Path(__file__).parents[2]
DOCUMENTS = sorted([*ROOT.glob('*.md'), *(ROOT / 'docs').glob('*.md')])
FENCED = re.compile(r'^```.*?^```$', re.DOTALL | re.MULTILINE)


def anchors(document: Path) -> set[str]:
    """Return the anchors of a document, with those of its headings."""
    text = FENCED.sub('', document.read_text(encoding='utf-8'))
    headings = re.findall(r'^#+ +(.+)$', text, re.MULTILINE)
    # as GitHub makes them
    plain = (re.sub(r'[^\w\- ]', '', h.lower()) for h in headings)
    named = re.findall(r'<a id="([^"]+)"></a>', text)
    return {*named, *(heading.replace(' ', '-') for heading in plain)}


def links(document: Path) -> list[str]:
    """Return the targets of the links that are no addresses in the web."""
    text = FENCED.sub('', document.read_text(encoding='utf-8'))
    text = re.sub(r'`[^`\n]*`', '', text)
    found = re.findall(r'\]\(([^)\s]+)\)', text)
    return [link for link in found if not link.startswith('https://')]


@pytest.mark.parametrize('document', DOCUMENTS, ids=lambda path: path.name)
def test_links(document: Path) -> None:
    for link in links(document):
        path, _, anchor = link.partition('#')
        target = document.parent / path if path else document
        # the site has no page for a folder
        assert target.is_file(), link
        if anchor:
            assert anchor in anchors(target), link


def test_links_are_found() -> None:
    assert '#the-protocol' in links(ROOT / 'docs/control.md')
    assert 'the-protocol' in anchors(ROOT / 'docs/control.md')


def test_each_page_is_linked() -> None:
    index = ROOT / 'docs/README.md'
    pages = {path.name for path in DOCUMENTS if path.parent == index.parent}
    assert set(links(index)) >= pages - {index.name}
