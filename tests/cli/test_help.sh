#!/bin/sh
# --help prints on standard output and lists every option; the command accepts every listed option.
. "$(dirname "$0")/lib.sh"

# options_of COMMAND: prints the expected options of the command, one per line.
options_of() {
    common='--threads --memory-limit --no-external --json --help'
    raw='--dims --type --big-endian --spacing --fill --time --channel --index --series'
    operand='--dims --raw-type --big-endian --spacing --fill --time --channel'
    result='-o --type'
    keep='--keep --rms --lossless-algebra --step'
    look='--size --zoom --engine --mode --transfer --background --level --step --oversample --ray-order --keep-mb'
    look="$look --colormap --window --opacity-scale --rescale --footprint --footprint-size --sigma --iso --iso-colour --shade --light --occlusion --shadows --fill-light --keep-brightness --samples --ambient --diffuse --specular --shininess --gradient-opacity --order --footprint-plane --tile --spectrum --rho --schedule --depth-cue"
    case $1 in
    compress) echo "$common $raw --ratio --bpv --psnr --max-error --lossless --labels --keep --attributes --label-table --transform --block --no-lap --effort --fast --smallest --force --stream --background --bricks -o --as --time-step --channel-names --channel-colors" ;;
    decompress) echo "$common --box --level --time --channel --zarr-format" ;;
    transcode) echo "$common --ratio --bpv --psnr --force --background --bricks --time --channel" ;;
    info) echo "$common $raw --build --layout --label-table" ;;
    verify) echo "$common" ;;
    compare) echo "$common $raw" ;;
    render) echo "$common $raw $look -o --depth --opacity --budget-ms --azimuth --elevation --perspective --eye --look-at --up --clip --clip-plane --view --annotate --turntable --fps --quality --bits --roll --psnr --ratio --progressive --poses --integrals --channel-colors --over-time --mirror --certify --fit --overlay --overlay-transfer --overlay-window --overlay-opacity --overlay-depth --overlay-labels --overlay-label-table --labels --label-table" ;;
    view) echo "$common $raw --overlay --overlay-transfer --overlay-window --overlay-opacity --overlay-depth --overlay-labels --overlay-label-table --port --listen --host --keep-mb --times-mb --label-table --no-browser --once" ;;
    export) echo "$common --html -o --site --title --caption --link --time --channel" ;;
    bake) echo "$common $raw -o --axis --transfer --shade --light --level --rho --spectrum --tile --footprint --footprint-size --sigma" ;;
    bench) echo "$common $raw $look --views --repeat" ;;
    add) echo "$common $operand $result $keep --alpha --beta" ;;
    multiply) echo "$common $operand $result $keep --plan --explain" ;;
    convolve) echo "$common $operand $result $keep --kernel" ;;
    scale) echo "$common $operand $result --factor --offset" ;;
    gradient) echo "$common $operand $result $keep" ;;
    stats) echo "$common $operand" ;;
    measure) echo "$common $operand --above --below --box --ellipsoid" ;;
    evaluate) echo "$common $operand -o --count --start --step --points" ;;
    esac | tr ' ' '\n' | sort
}

commands='compress decompress transcode info verify compare render view export bake bench add multiply convolve scale gradient stats measure evaluate'

# Every help text: status 0, empty stderr, lines that fit.
expect_help() {
    expect_done "$@"
    expect_number "$(wc -l <"$out")" '>' 5
    awk 'length > 120 { exit 1 }' "$out" || fail 'must have lines of at most 120 characters'
    head -n 1 "$out" | grep -q '^usage: cvol ' || fail 'must begin with the usage'
}

for help in --help -h help; do
    expect_help cvol $help
    for command in $commands; do
        grep -q "^  $command " "$out" || fail "must name $command"
    done
done

for command in $commands; do
    expect_help cvol $command --help
    cp "$out" help
    expect_help cvol $command -h
    expect_same_file help "$out"
    expect_help cvol $command in.nrrd --json --help # in any position
    expect_help cvol help $command
    expect_same_file help "$out"
    head -n 1 help | grep -q "^usage: cvol $command " || fail "must print the usage of $command"
    options_of $command >wanted
    sed -n 's/^  \(-[-a-z]*\) .*/\1/p' help | sort >shown
    expect_same_file wanted shown
    # The command knows every option of the help.
    while read -r option; do
        [ "$option" != --help ] || continue
        run cvol $command "$option"
        case $(cat "$err") in
        *'unknown option'*) fail "$option must be known" ;;
        esac
    done <shown
done

# The examples of the help run, and the printed defaults are the defaults of the command.
expect_done cvol compress --help
grep -q 'default 30' "$out" || fail 'must print the default ratio'
sed -n 's/^  \(cvol [a-z]*\) .*/\1/p' "$out" | sort -u >examples
echo 'cvol compress' >wanted
expect_same_file wanted examples

# The help names all transfer functions, as the message does.
expect_done cvol render --help
cp "$out" help
make_volume small.raw uint8 8x8x8
expect_done cvol compress small.raw small.cvol --dims 8x8x8 --type uint8 --psnr 40
expect_failure 2 'there are: auto ' cvol render small.cvol -o x.png --transfer nothing
for name in $(sed -n 's/.*there are: //p' "$err"); do
    sed -n '/^Transfer functions:/,/^$/p' help | tr ' ' '\n' | grep -qxF -- "$name" || fail "must name $name"
done

expect_done cvol --version
case $(cat "$out") in
'cvol '[0-9]*.[0-9]*.[0-9]*) ;;
*) fail 'must print: cvol MAJOR.MINOR.PATCH' ;;
esac
version=$(sed 's/cvol //' "$out")
expect_done cvol info --build --json
expect_equal "$(value_of version string)" "$version"

if [ -c /dev/full ]; then
    full() { "$CVOL" "$@" >/dev/full; }
    for words in --help --version 'compress --help' 'info --build' 'info --build --json'; do
        expect_failure 1 'cannot write to standard output' full $words
    done
fi
