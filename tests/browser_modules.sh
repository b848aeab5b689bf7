# shellcheck shell=sh
# install_browser_modules TESTS FOLDER: installs the npm packages of the browser tests, which TESTS lists, into FOLDER,
# and sets CVOL_CHROMIUM and CVOL_BROWSER_MODULES. It ends the test as skipped (77) where npm cannot install them.
install_browser_modules() {
    CVOL_CHROMIUM=$(command -v chromium)
    CVOL_BROWSER_MODULES=$2/node_modules
    export CVOL_CHROMIUM CVOL_BROWSER_MODULES PLAYWRIGHT_SKIP_BROWSER_DOWNLOAD=1
    mkdir -p "$2"
    if ! cmp -s "$1/package-lock.json" "$2/package-lock.json" || [ ! -e "$2/complete" ]; then
        rm -rf "$2/complete" "$CVOL_BROWSER_MODULES"
        cp "$1/package.json" "$1/package-lock.json" "$2"
        (cd "$2" && npm ci --no-audit --no-fund >npm.log 2>&1) || {
            cat "$2/npm.log"
            [ -n "${CI-}" ] && exit 1
            echo 'skipped: npm could not install what the tests need'
            exit 77
        }
        : >"$2/complete"
    fi
}
