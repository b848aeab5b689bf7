#!/bin/sh
# Outputs that cannot be written: one sentence, status 1, and existing files stay unchanged.
. "$(dirname "$0")/lib.sh"

dims=40x36x32
raw="--dims $dims --type uint16"
make_volume in.raw uint16 $dims
make_nrrd in.nrrd in.raw uint16 40 36 32
expect_done cvol compress in.nrrd in.cvol --psnr 60
formats='nrrd nhdr nii nii.gz mha mhd raw'

# for_each_output CHECK: runs CHECK NAME COMMAND... for every kind of output; NAME is the last argument of COMMAND.
for_each_output() {
    $1 out.cvol cvol compress in.nrrd
    for format in $formats; do $1 out.$format cvol decompress in.cvol; done
    $1 out.png cvol render in.cvol --size 128 -o
}

# ---- folders -------------------------------------------------------------------------------------

into_missing_folder() {
    name=$1
    shift
    expect_failure 1 "missing/$name: *No such file" "$@" "missing/$name"
    expect_failure 1 "in.raw/$name: *Not a directory" "$@" "in.raw/$name"
    expect_no_file missing
}
for_each_output into_missing_folder

onto_folder() {
    mkdir "$1"
    name=$1
    shift
    expect_failure 1 "$name: is a directory" "$@" "$name"
    rmdir "$name" || fail "$name must still be an empty folder"
}
for_each_output onto_folder

# ---- read-only files and folders, also for root --------------------------------------------------

onto_read_only() {
    name=$1
    shift
    echo old >"$name"
    cp "$name" old
    chmod 444 "$name"
    expect_failure 1 "$name: is read-only" "$@" "$name"
    expect_same_file "$name" old
    ln -s "$name" "link-$name"
    expect_failure 1 "link-$name: is read-only" "$@" "link-$name"
    expect_same_file "$name" old
    rm -f "$name" old "link-$name"
}
for_each_output onto_read_only

into_read_only_folder() {
    name=$1
    shift
    mkdir closed
    chmod 555 closed
    expect_failure 1 "closed/$name: *Permission denied" "$@" "closed/$name"
    rmdir closed || fail 'closed must be empty'
}
if [ "$(id -u)" = 0 ]; then
    echo 'skipped: a read-only folder (root may write there)'
else
    for_each_output into_read_only_folder
fi

# A name that is too long.
long=$(printf '%0260d' 0)
onto_long_name() {
    ending=${1#out}
    shift
    expect_failure 1 'cannot be written: File name too long' "$@" "$long$ending"
}
for_each_output onto_long_name

# ---- a full disk ---------------------------------------------------------------------------------

full=$top/full
onto_full_disk() {
    name=$1
    shift
    rm -rf "$full"/* # left by the check of the previous format
    echo old >"$full/$name"
    dd if=/dev/zero of="$full/rest" bs=1k >/dev/null 2>&1 || : # fills the disk
    ls -A "$full" >before
    expect_failure 1 "$full/out.*: No space left" "$@" "$full/$name"
    ls -A "$full" >after
    expect_same_file before after
    expect_equal "$(cat "$full/$name")" old
}
# Nearly full: the file can be created but not completed.
onto_nearly_full_disk() {
    name=$1
    shift
    rm -rf "$full"/*
    echo old >"$full/$name"
    dd if=/dev/zero of="$full/rest" bs=1k count=56 2>/dev/null
    ls -A "$full" >before
    expect_failure 1 "$full/out.*: No space left" "$@" "$full/$name"
    ls -A "$full" >after
    expect_same_file before after
    expect_equal "$(cat "$full/$name")" old
}
mkdir "$full"
: >before
: >after
if mount -t tmpfs -o size=64k cvol-test "$full" 2>/dev/null; then
    mounted=$full
    for_each_output onto_full_disk
    onto_nearly_full_disk out.cvol cvol compress in.nrrd --ratio 2
    for format in $formats; do
        onto_nearly_full_disk out.$format cvol decompress in.cvol
    done
    umount "$full"
    mounted=
else
    echo 'skipped: a full tmpfs (only root may mount one)'
fi

# A limit of file sizes: cvol prints a sentence; the signal SIGXFSZ must not end the process.
limited() { (ulimit -f 8 && exec "$CVOL" "$@"); }
for words in 'compress in.nrrd limited.cvol --ratio 2' 'decompress in.cvol limited.nrrd'; do
    expect_failure 1 'limited.*: File too large' limited $words
done

onto_full_device() {
    name=$1
    shift
    ln -s /dev/full "$name"
    expect_failure 1 'No space left' "$@" "$name"
    [ -L "$name" ] && [ -c "$name" ] || fail "$name must still point to /dev/full"
    rm "$name"
}
if [ -c /dev/full ]; then
    onto_full_device out.cvol cvol compress in.nrrd
    onto_full_device out.png cvol render in.cvol --size 128 -o
    for format in nrrd nii mha raw; do onto_full_device out.$format cvol decompress in.cvol; done
    # Standard output.
    full_stdout() { "$CVOL" "$@" >/dev/full; }
    for words in 'info in.cvol' 'info in.cvol --json' 'info in.nrrd' 'compare in.cvol in.nrrd' \
        'compare in.cvol in.nrrd --json' 'bench render in.cvol --views 1 --repeat 1 --json'; do
        expect_failure 1 'cannot write to standard output' full_stdout $words
    done
    # The picture is complete nevertheless.
    expect_status 1 full_stdout render in.cvol -o out.png --json
    expect_sentence 'cannot write to standard output'
    expect_done cvol render in.cvol -o again.png
    expect_same_file out.png again.png
    rm out.png again.png
else
    echo 'skipped: /dev/full'
fi
closed_stdout() { "$CVOL" "$@" >&-; }
expect_status 1 closed_stdout info in.cvol
expect_sentence 'cannot write to standard output'

# ---- the input as the output ---------------------------------------------------------------------

cp in.cvol old.cvol
cp in.cvol volume.png
cp in.cvol volume.raw
ln in.cvol hard.cvol
ln -s in.cvol soft.cvol
ln in.cvol hard.nrrd
ln -s in.cvol soft.png
for name in in.cvol ./in.cvol "$PWD/in.cvol" hard.cvol soft.cvol; do
    expect_failure 1 'input and output are the same file' cvol compress in.cvol "$name" --ratio 50
    expect_failure 1 'input and output are the same file' cvol compress "$name" in.cvol --ratio 50
done
expect_failure 1 'input and output are the same file' cvol decompress in.cvol hard.nrrd
expect_failure 1 'input and output are the same file' cvol decompress volume.raw volume.raw
expect_failure 1 'input and output are the same file' cvol render in.cvol -o soft.png
expect_failure 1 'input and output are the same file' cvol render volume.png -o volume.png
expect_same_file in.cvol old.cvol
expect_same_file volume.raw old.cvol

# A header and its separate sample file are replaced together: both are old or both are new, whichever fails.
expect_done cvol compress in.nrrd other.cvol --ratio 40
for format in nhdr mhd; do
    expect_done cvol decompress in.cvol pair.$format
    expect_done cvol info pair.$format
    for closed in pair.$format pair.raw; do
        cp pair.raw old.samples
        cp pair.$format old.header
        chmod 444 $closed
        expect_failure 1 "$closed: is read-only" cvol decompress other.cvol pair.$format
        expect_same_file pair.raw old.samples
        expect_same_file pair.$format old.header
        rm -f $closed
        mkdir $closed
        expect_failure 1 "$closed: is a directory" cvol decompress other.cvol pair.$format
        rmdir $closed
        expect_failure 1 'File name too long' cvol decompress other.cvol "$long.$format"
        expect_done cvol decompress in.cvol pair.$format
    done
    rm -f pair.*
done

# A dangling link as output: cvol creates the file that it names.
ln -s born.cvol dangling.cvol
expect_done cvol compress in.nrrd dangling.cvol
expect_done cvol info dangling.cvol
# Permissions: a new file follows the umask, an existing file keeps its own.
umask 027
expect_done cvol compress in.nrrd new.cvol
expect_equal "$(ls -l new.cvol | cut -c 1-10)" '-rw-r-----'
chmod 600 new.cvol
expect_done cvol compress in.nrrd new.cvol
expect_equal "$(ls -l new.cvol | cut -c 1-10)" '-rw-------'
