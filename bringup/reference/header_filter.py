#!/usr/bin/python3 -IS
# SPDX-License-Identifier: Apache-2.0
"""header_filter.py ROOM HEADER: prints a header as Doxygen reads it, with the same line numbers.

Adds what the sources state in another form: the file's first comment as its description, the room as
the group of each namespace's members, the meaning of each parameter, from its struct's visit(), as the
member's comment, a comment of several members in one declaration to each of them, and a function's
comment to the overloads that follow it directly. Leaves out visit(), defaulted functions and moves.
"""
import pathlib
import re
import sys

FIELD = re.compile(r'field\(\s*"\w+",\s*(\w+)\s*,(.*?)\);$', re.M | re.S)
VISIT = re.compile(r'^  template <class Visitor>\n  void visit\(Visitor&& field\) \{\n.*?^  \}\n', re.M | re.S)
DECLARATOR = r'\w+(?: = [^,;{]+|\{[^}]*\})?'
TYPE = r'(?:static constexpr |inline constexpr )?[\w:]+(?:<[^;=]*>)?'
SHARED = re.compile(rf'^( *{TYPE}) ({DECLARATOR}(?:, {DECLARATOR})+);(?! *///<)', re.M)
SEVERAL = re.compile(SHARED.pattern.replace('(?! *///<)', ' +///< (.*)$'), re.M)
LEFT_OUT = (r'^ *[^\n;{}/]*= (?:default|delete);.*$',
            r'^  (?:explicit )?(?:\w+& operator=|\w+)\(\w+&&(?: other)?\) noexcept.*$')


def blank(match):
    return '\n' * match[0].count('\n')


def meanings(visit):
    """Member → meaning, in one line."""
    for member, rest in FIELD.findall(visit):
        texts = re.findall(r'"((?:[^"\\]|\\.)*)"', re.sub(r'OneOf\{.*?\}\}', '', rest, flags=re.S))
        yield member, ''.join(texts).replace('\\"', '"')


def with_parameters(text):
    for visit in reversed(list(VISIT.finditer(text))):
        head, tail = text[:visit.start()], text[visit.end():]
        begin = max(head.rfind('\nstruct '), head.rfind('\nclass '))
        fields = SHARED.sub(one_by_one, head[begin:])
        for member, meaning in meanings(visit[0]):
            fields = re.sub(rf'( [\w:<>]+ {member}\b[^;]*;)(?! */(?:\*\*|//)<)',
                            lambda line, meaning=meaning: f'{line[1]} /**< {meaning} */', fields, count=1)
        text = head[:begin] + fields + blank(visit) + tail
    return text


def one_by_one(match):
    return ' '.join(f'{match[1]} {name};' for name in re.findall(DECLARATOR, match[2]))


def each_documented(match):
    kind, names, comment = match.groups()
    return ' '.join(f'{kind} {name}; /**< {comment} */' for name in re.findall(DECLARATOR, names))


def with_overloads(text):
    """Repeats a function's comment at the declarations of the same name that follow it directly."""
    lines, comment, name = text.split('\n'), [], None
    for number, line in enumerate(lines):
        if re.match(r' *///(?!<)', line):
            comment, name = ([] if name or not comment else comment) + [line.split('///', 1)[1]], None
            continue
        found = re.match(r'( *)[^(=;/]*?(\w+)\(', line)
        if not line or line.lstrip().startswith(('//', 'private:')):
            comment, name = [], None
        elif found and name == found[2] and comment and len(found[1]) <= 2:
            lines[number] = f'/** {" ".join(comment)} */ {line}'
        elif found and comment and name is None:
            name = found[2]
    return '\n'.join(lines)


def main(room, header):
    text = pathlib.Path(header).read_text(encoding='utf-8')
    text = with_parameters(text)
    for pattern in LEFT_OUT:
        text = re.sub(pattern, '', text, flags=re.M)
    text = with_overloads(SEVERAL.sub(each_documented, text))
    head, rest = text.split('#pragma once', 1)
    head = head.replace('// SPDX-License-Identifier: Apache-2.0', '/// @file', 1).replace('\n// ', '\n/// ')
    for name in re.findall(r'^namespace ([\w:]+) \{\n\n', rest, re.M):
        rest = rest.replace(f'namespace {name} {{\n\n', f'namespace {name} {{ /** @addtogroup {room}\n@{{ */\n', 1)
        rest = rest.replace(f'\n}}  // namespace {name}\n', f'\n/** @}} */ }}  // namespace {name}\n', 1)
    sys.stdout.write(head + '#pragma once' + rest)


try:
    main(*sys.argv[1:])
except Exception:
    print('/** @file\n@ref the_filter_failed */')  # Doxygen takes no notice of its exit status
    raise
