#!/bin/sh
# Checks every #include "..." of the code, and every import of the page's modules, against one table of folders, and
# that files do not include each other in a cycle. A folder may include its own headers, those of the folders in its line, and the public ones (cvol/).
# `parent/*` means all folders of a parent. Cycles are between files; a .c and its own .h count as one.
set -eu
cd "$(dirname "$0")/.."

table='
src/base:
src/windows:
src/windows/include:
src/windows/include/sys:
src/transform:                  base
src/image:                      base array/core codec/section codec/container
src/array/core:                 base transform
src/array/block:                base transform array/core
src/array/truncate:             base transform array/core array/block
src/array/evaluate:             base transform array/core array/block array/truncate
src/array/algebra:              base transform array/core array/block array/truncate array/evaluate
src/array/convolve:             base transform array/core array/block array/truncate array/evaluate array/algebra
src/array/multiply:             base transform array/core array/block array/truncate array/evaluate array/algebra
src/codec/section:              base
src/codec/entropy:              base codec/tables
src/codec/tables:
src/codec/quantize:             base transform array/* codec/entropy
src/codec/neural:               base transform array/* codec/entropy codec/quantize codec/tables
src/codec/brick:                base transform array/* codec/section codec/entropy codec/quantize codec/neural
src/codec/mask:                 base transform array/* codec/section codec/entropy codec/quantize codec/brick codec/tables
src/codec/labels:               base array/core codec/entropy codec/quantize codec/mask
src/codec/residual:             base transform array/* codec/section codec/entropy codec/quantize codec/brick codec/labels
src/codec/container:            base transform array/* codec/section codec/entropy codec/quantize codec/brick codec/residual codec/mask
src/codec/rate:                 base transform array/* codec/*
src/volume/io:                  base
src/volume/formats:             base volume/io
src/volume/formats/tiff:        base volume/io
src/volume/formats/dicom:       base volume/io
src/volume/formats/pictures:    base volume/io
src/volume/formats/vtk:         base volume/io
src/volume/formats/zarr:        base volume/io
src/volume/formats/vdb:         base volume/io
src/volume/formats/matlab:      base volume/io
src/volume:                     base volume/io volume/formats volume/formats/zarr volume/formats/vdb
src/render:
src/render/transfer:            base array/core
src/render/view:                base image render/transfer
src/render/light:               base render/view render/transfer
src/render/engine:              base array/* image render/view render/transfer
src/render/ray:                 base volume image render/engine render/view render/transfer render/light
src/render/look:                base array/* render/view render/transfer render/light render/sheet/frame render/sheet
src/render/splat:               base transform array/* volume image render/engine render/view render/transfer render
src/render/fourier:             base transform array/* volume image render/engine render/view render/transfer
src/render/spectral:            base transform array/* codec/* volume image render/engine render/view render/transfer render/splat
src/render/sheet/frame:         base transform array/* image render/engine render/view render/transfer
src/render/sheet/band:          base transform array/* render/transfer render/sheet/frame
src/render/sheet/warp:          base image render/engine render/view render/sheet/frame
src/render/sheet:               base transform array/* image render/engine render/view render/transfer render/light render/sheet/frame render/sheet/band render
src/mpi:                        base array/core array/evaluate render/view render/transfer render/light render/sheet codec/rate
src/render/sheet/kernels:       base transform array/* render/view render/sheet/frame render/sheet/band
src/render/sheet/kernels/image_order: base render/sheet/kernels
src/render/sheet/kernels/composite: base render/view render/sheet/kernels render/sheet/kernels/image_order
src/render/sheet/kernels/lit_object_order: base render/view render/sheet/kernels render/sheet/kernels/composite
src/render/sheet/kernels/lit_image_order: base render/view render/sheet/kernels render/sheet/kernels/composite
src/render/sheet/kernels/project: base render/sheet/kernels
tools:                          tools/base tools/compress tools/render
tools/base:                     tools/words base
tools/labels:                   tools/base
tools/algebra:                  tools/base tools/words
tools/compress:                 tools/base tools/words tools/labels
tools/info:                     tools/base tools/labels
tools/render:                   tools/base tools/words tools/labels tools/overlay render
tools/view:                     tools/base tools/labels tools/overlay tools/render viewer viewer/base base
tools/mpi:                      base tools/base tools/compress tools/render tools/view
tools/words:
tools/overlay:                  base
viewer/base:                    tools/overlay
viewer/volumes:                 viewer/base tools/overlay
viewer/view:                    viewer/base viewer/volumes tools/words tools/overlay
viewer/service:                 viewer/base viewer/volumes
viewer/requests:                viewer/base viewer/volumes viewer/view viewer/service tools/words tools/overlay
viewer/films:                   viewer/base viewer/volumes viewer/view viewer/service
viewer/http:                    viewer/base viewer/volumes viewer/service viewer/requests viewer/films
viewer:                         viewer/base viewer/service viewer/films viewer/http
viewer/page/state:
viewer/page/controls:           viewer/page/state
viewer/page/transfer:           viewer/page/state viewer/page/controls
viewer/page/panels:             viewer/page/state viewer/page/controls viewer/page/transfer
viewer/page/input:              viewer/page/controls
viewer/page/measure:            viewer/page/state viewer/page/controls
viewer/page/bookmarks:          viewer/page/state viewer/page/controls
viewer/page/picture:            viewer/page/state viewer/page/controls viewer/page/panels viewer/page/input viewer/page/measure
viewer/page/slices:             viewer/page/state viewer/page/controls viewer/page/transfer viewer/page/measure
viewer/page/compare:            viewer/page/state viewer/page/controls viewer/page/picture viewer/page/input
viewer/page/exports:            viewer/page/state viewer/page/controls
viewer/page/bars:               viewer/page/state viewer/page/controls
viewer/page:                    viewer/page/state viewer/page/panels viewer/page/input viewer/page/picture viewer/page/bars viewer/page/measure viewer/page/bookmarks
web/page:                       viewer/page/state viewer/page/controls
web:                            viewer/base viewer/service viewer/requests tools/words base render/engine volume/formats volume/formats/dicom volume/formats/vdb volume/formats/zarr volume/io
plugin:
plugin/anari:
plugin/itk:
'

list=$(mktemp)
trap 'rm -f "$list"' EXIT
find src tools viewer web plugin -name '*.[ch]' -o -name '*.cpp' -o -name '*.inc' -o -path '*/page/*.js' | sort >"$list"
printf '%s\n' "$table" | awk -v list="$list" '
function folder(path) { sub(/\/[^\/]*$/, "", path); return path }
# a/./b and a/c/../b: a/b
function resolved(path) {
    path = "/" path
    gsub(/\/\.\//, "/", path)
    while (sub(/\/[^\/.]+\/\.\.\//, "/", path))
        ;
    return substr(path, 2)
}
function allowed(from, to,    i, n, words) {
    if (from == to)
        return 1
    n = split(may[from], words, " ")
    for (i = 1; i <= n; i++) {
        if (words[i] == to || "src/" words[i] == to)
            return 1
        if (sub(/\*$/, "", words[i]) && index(to, "src/" words[i]) == 1)
            return 1
    }
    return 0
}
# Depth first: a unit that is already on the path closes a cycle.
function visit(unit,    i, n, next_units) {
    state[unit] = 1
    path[++depth] = unit
    n = split(uses[unit], next_units, " ")
    for (i = 1; i <= n; i++) {
        if (state[next_units[i]] == 1) {
            circle = next_units[i]
            for (j = depth; path[j] != next_units[i]; j--)
                circle = path[j] " > " circle
            print "circle: " next_units[i] " > " circle
            failed = 1
        } else if (!state[next_units[i]])
            visit(next_units[i])
    }
    depth--
    state[unit] = 2
}
/:/ {
    at = index($0, ":")
    name = substr($0, 1, at - 1)
    known[name] = 1
    may[name] = substr($0, at + 1)
}
END {
    while ((getline file < list) > 0)
        files[++count] = file
    for (k in files)
        exists[files[k]] = 1
    for (k = 1; k <= count; k++) {
        file = files[k]
        from = folder(file)
        if (++held[from] > 45)
            crowded[from] = 1
        if (!known[from]) {
            print from " is no folder of the table in tests/check_rooms.sh"
            known[from] = failed = 1
        }
        unit = file
        sub(/\.[a-z]+$/, "", unit)
        while ((getline line < file) > 0)
            if (line ~ /^[ \t]*#[ \t]*include "/ || (file ~ /\.js$/ && line ~ /^(import|\}) .*"\./)) {
                split(line, parts, "\"")
                header = file ~ /\.js$/ ? resolved(from "/" parts[2]) : parts[2]
                if (header ~ /^cvol\//)
                    continue
                target = exists["src/" header] ? "src/" header : \
                         exists[from "/" header] ? from "/" header : header
                if (!exists[target] && (target !~ /\// || file ~ /\.js$/))
                    continue # a generated header, a module that web/bundle.mjs chooses
                includes++
                to = exists[target] ? folder(target) : header
                if (!exists[target] && exists[header])
                    to = folder(header)
                if (!allowed(from, to)) {
                    print file " includes " header ": " from " may include only:" may[from]
                    failed = 1
                }
                other = target
                sub(/\.[a-z]+$/, "", other)
                if (other != unit && index(" " uses[unit] " ", " " other " ") == 0)
                    uses[unit] = uses[unit] " " other
            }
        close(file)
        units[++unit_count] = unit
    }
    for (k = 1; k <= unit_count; k++)
        if (!state[units[k]])
            visit(units[k])
    for (name in crowded) {
        print name " holds " held[name] " files, more than 45"
        failed = 1
    }
    if (!failed)
        print "rooms: " count " files, " includes " includes, every one follows the table; no circle"
    exit failed
}'
