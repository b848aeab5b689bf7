# shellcheck shell=sh
# one_by_one LOCK COMMAND...: runs a command when no other test runs one with this lock, where flock can do that.
one_by_one() {
    if command -v flock >/dev/null; then
        flock "$@"
    else
        shift
        "$@"
    fi
}

# install_browser_modules TESTS FOLDER: installs the npm packages of the browser tests, which TESTS lists, into FOLDER,
# and sets CVOL_CHROMIUM and CVOL_BROWSER_MODULES. It ends the test as skipped (77) where npm cannot install them.
install_browser_modules() {
    CVOL_CHROMIUM=$(command -v chromium)
    CVOL_BROWSER_MODULES=$2/node_modules
    export CVOL_CHROMIUM CVOL_BROWSER_MODULES PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1
    mkdir -p "$2"
    # shellcheck disable=SC2016 # the other shell expands these
    one_by_one "$2/lock" sh -c '
        cmp -s "$1/package-lock.json" "$2/package-lock.json" && [ -e "$2/complete" ] && exit
        rm -rf "$2/complete" "$2/node_modules"
        cp "$1/package.json" "$1/package-lock.json" "$2"
        cd "$2" && npm ci --no-audit --no-fund >npm.log 2>&1 && : >complete' sh "$1" "$2" || {
        cat "$2/npm.log"
        [ -n "${CI-}" ] && exit 1
        echo 'skipped: npm could not install what the tests need'
        exit 77
    }
}
