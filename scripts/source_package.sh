# fetch: gets the sources of a library from Debian's source packages, with Debian's patches. Sourced by scripts that set
# $folder.

# The system's list of packages may lack sources: use lists of our own.
fetch() { # PACKAGE: unpacks it into $folder/PACKAGE
    lists=$folder/apt
    [ -e "$lists/ready" ] || {
        mkdir -p "$lists/lists/partial"
        apt-get indextargets --format '$(ORIGIN) $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' |
            awk '$1 == "Debian" && $4 == "main" { print "deb-src", $2, $3, $4 }' | LC_ALL=C sort -ru >"$lists/sources.list"
        from_lists update
        : >"$lists/ready"
    }
    mkdir -p "$folder/$1-files" "$folder/$1"
    (cd "$folder/$1-files" && from_lists source --download-only "$1")
    tar xf "$(ls "$folder/$1-files/$1"_*.orig.tar.* | grep -v '\.asc$')" -C "$folder/$1" --strip-components=1
    tar xf "$(ls "$folder/$1-files/$1"_*.debian.tar.*)" -C "$folder/$1"
    patches=$folder/$1/debian/patches
    [ ! -e "$patches/series" ] || sed 's/#.*//' "$patches/series" | while read -r name; do
        [ -z "$name" ] || patch -s -p1 -d "$folder/$1" <"$patches/$name"
    done
}
from_lists() {
    apt-get -qq -o Dir::Etc::SourceList="$lists/sources.list" -o Dir::Etc::SourceParts=- \
        -o Dir::State::Lists="$lists/lists" -o APT::Sandbox::User="$(id -un)" "$@" >"$folder/apt.log" 2>&1 || {
        cat "$folder/apt.log" >&2
        echo "$(basename "$0"): cannot get the sources of libraries: set the variables that $0 lists" >&2
        exit 1
    }
}
