#!/bin/sh
# The C program that a document shows.
# usage: tests/extract_example.sh DOCUMENT OUT.c
set -eu
awk '/^```c$/ { on = 1; next } /^```$/ { on = 0 } on' "$1" >"$2"
[ -s "$2" ] || { echo "$1 shows no C program" >&2; exit 1; }
