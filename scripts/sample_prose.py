#!/usr/bin/env python3
"""Draws random comments, messages and names from the sources, for a review of their English.

usage: scripts/sample_prose.py [--seed N] [--count N]
"""
import argparse
import random
import re
import subprocess
import sys


def read_sources():
    names = subprocess.run(['git', 'ls-files', '*.c', '*.h', '*.py', '*.sh', '*.js', ':!third_party'], capture_output=True,
                           text=True, check=True).stdout.split()
    return {name: open(name, encoding='utf-8').read() for name in names}


def list_comments(sources):
    for name, text in sources.items():
        pattern = r'/\*(.*?)\*/' if name.endswith(('.c', '.h')) else r'(?:^|\s)(?://|#)[^!](.*)$'
        for match in re.finditer(pattern, text, re.S if name.endswith(('.c', '.h')) else re.M):
            words = ' '.join(re.sub(r'\n\s*\*', '\n', match.group(1)).split())
            if len(words.split()) >= 4:
                yield f"{name}:{text.count(chr(10), 0, match.start()) + 1}: {words}"


def list_messages(sources):
    for name, text in sources.items():
        if name.startswith(('src/', 'tools/', 'viewer/', 'plugin/', 'python/cvol/')):
            bare = re.sub(r'/\*.*?\*/', lambda m: ' ' * len(m.group()), text, flags=re.S)
            for match in re.finditer(r'"((?:[^"\\\n]|\\.)*)"(?:\s*(?:PRI\w+)?\s*"(?:[^"\\\n]|\\.)*")*', bare):
                words = ''.join(re.findall(r'"((?:[^"\\\n]|\\.)*)"', match.group()))
                if len(words.split()) >= 4:
                    yield f"{name}:{bare.count(chr(10), 0, match.start()) + 1}: {words}"


def list_names(sources):
    for name, text in sources.items():
        if name.endswith(('.c', '.h')) and not name.startswith('tests/'):
            for match in re.finditer(r'^(?:CVOL_\w+ |static |const |struct |enum |unsigned )*\w+ \**(\w+)\(', text, re.M):
                yield f"{name}:{text.count(chr(10), 0, match.start()) + 1}: {match.group(1)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seed', type=int, default=random.randrange(10 ** 9))
    parser.add_argument('--count', type=int, default=10)
    arguments = parser.parse_args()
    print(f'seed {arguments.seed}')
    sources = read_sources()
    for what, found in (('comments', list_comments(sources)), ('messages', list_messages(sources)),
                        ('names', list_names(sources))):
        found = sorted(set(found))
        print(f'\n{what} ({len(found)} in all)')
        for line in random.Random(f'{arguments.seed} {what}').sample(found, arguments.count):
            print(line)


if __name__ == '__main__':
    sys.exit(main())
