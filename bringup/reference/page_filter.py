#!/usr/bin/python3 -IS
# SPDX-License-Identifier: Apache-2.0
"""page_filter.py ROOT DOCUMENT: prints a Markdown document of the repository as Doxygen reads it.

Links between documents and to their headings become references, which Doxygen checks: a link to what
does not exist is a warning there. Links to other files of the repository become plain text.
"""
import os
import pathlib
import re
import sys

LINK = re.compile(r'(?<!!)\[([^\]]+)\]\(([^)\s]+)\)')
IMAGE = re.compile(r'!\[([^\]]*)\]\(([^)\s]+)\)')


def page_id(name):
    return 'index' if name == 'README.md' else re.sub(r'\W', '_', name.removesuffix('.md')).strip('_')


def heading_id(name, slug):
    return page_id(name) + '__' + re.sub(r'[^a-z0-9]', '_', slug)


def slug(heading):
    """The fragment by which GitHub addresses a heading."""
    return re.sub(r'[^\w\- ]', '', heading.strip().lower()).replace(' ', '-')


class Page:
    def __init__(self, root, document):
        self.root = pathlib.Path(root).resolve()
        self.name = str(pathlib.Path(document).resolve().relative_to(self.root))

    def link(self, match):
        text, target = match[1], match[2]
        if re.match(r'[a-z]+:', target):
            return match[0]
        path, _, fragment = target.partition('#')
        file = os.path.normpath(os.path.join(os.path.dirname(self.name), path)) if path else self.name
        if not file.endswith('.md') and (self.root / file).exists():
            return text
        identity = heading_id(file, fragment) if fragment else page_id(file)
        return f'[{text}](@ref {identity})'

    def heading(self, match):
        if match[1] == '#':
            if page_id(self.name) == 'index':
                return match[0]  # Doxygen gives the main page this name
            return f'# {match[2]} {{#{page_id(self.name)}}}'
        return f'{match[1]} {match[2]} {{#{heading_id(self.name, slug(match[2]))}}}'

    def prose(self, text):
        text = IMAGE.sub(lambda image: f'![{image[1]}]({os.path.basename(image[2])})', text)
        text = LINK.sub(self.link, text)
        return re.sub(r'^(#+) (.*)$', self.heading, text, flags=re.M)

    def text(self):
        whole = (self.root / self.name).read_text(encoding='utf-8')
        pieces = re.split(r'(^```.*?^```)', whole, flags=re.M | re.S)
        return ''.join(piece if piece.startswith('```') else self.prose(piece) for piece in pieces)


try:
    sys.stdout.write(Page(*sys.argv[1:]).text())
except Exception:
    print('@ref the_filter_failed')  # Doxygen takes no notice of its exit status
    raise
