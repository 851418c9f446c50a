# shellcheck shell=bash
# What the tools know about packages: root, apt and Debian's backports suite. Sourced after common.sh, never run.

APT_ETC=/etc/apt
WANTED=()
WANTED_FROM_BACKPORTS=()
APT_OPTIONS=(-y -qq -o Acquire::Retries=3 -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0)
APT_INDEX_IS_FRESH=no

is_installed() { # PACKAGE
    have dpkg-query && [[ $(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null) == installed ]]
}

installed_version_is_at_least() { # PACKAGE VERSION
    is_installed "$1" && dpkg --compare-versions "$(dpkg-query -W -f '${Version}' "$1")" ge "$2"
}

can_be_root() { [[ $EUID -eq 0 ]] || { have sudo && sudo -n true 2>/dev/null; }; }

apt_get_as_root() {
    local command=(env DEBIAN_FRONTEND=noninteractive apt-get "${APT_OPTIONS[@]}" "$@")
    [[ $EUID -eq 0 ]] || command=(sudo -n "${command[@]}")
    # apt's words go to stderr, and it gets no stdin to ask questions on.
    "${command[@]}" >&2 </dev/null
}

want() { # PACKAGE...
    local package
    for package in "$@"; do
        is_installed "$package" || WANTED+=("$package")
    done
}

want_from_backports() { WANTED_FROM_BACKPORTS+=("$@"); } # PACKAGE...

# Installs all that was wanted. Where nothing was, it does not even read the package index.
bring_in_wanted() {
    [[ ${#WANTED[@]} -gt 0 || ${#WANTED_FROM_BACKPORTS[@]} -gt 0 ]] || return 0
    require_apt_and_root
    if [[ ${#WANTED_FROM_BACKPORTS[@]} -gt 0 ]]; then
        install_from_backports "${WANTED_FROM_BACKPORTS[@]}"
    fi
    if [[ ${#WANTED[@]} -gt 0 ]]; then
        refresh_apt_index
        say "Installing ${WANTED[*]} ..."
        apt_get_as_root install --no-install-recommends "${WANTED[@]}" ||
            die "apt-get could not install ${WANTED[*]}; its message is above."
    fi
    WANTED=()
    WANTED_FROM_BACKPORTS=()
}

require_apt_and_root() {
    local backports commands=""
    backports=$(os_field VERSION_CODENAME)-backports
    [[ ${#WANTED[@]} -eq 0 ]] || commands="apt-get install ${WANTED[*]}"
    [[ ${#WANTED_FROM_BACKPORTS[@]} -eq 0 ]] ||
        commands+="${commands:+ && }apt-get install -t $backports ${WANTED_FROM_BACKPORTS[*]}"
    have apt-get || die "these packages (Debian's names) are missing: ${WANTED[*]} ${WANTED_FROM_BACKPORTS[*]}" \
        "and there is no apt-get here; install them with this system's own package manager, then run this again."
    can_be_root || die "packages are missing, and installing them needs root (or sudo without a password)." \
        "Run this as root, then start again: $commands"
}

refresh_apt_index() { # [APT OPTION...]
    [[ $APT_INDEX_IS_FRESH == no ]] || return 0
    say "Reading the package index ..."
    # One unreachable third-party source fails the whole update; whether it matters shows at the install.
    apt_get_as_root update "$@" || say "Some package sources could not be read; going on with the others."
    APT_INDEX_IS_FRESH=yes
}

# The entry for the backports suite is handed to apt as an option, so that the machine's own settings stay as they are.
install_from_backports() { # PACKAGE...
    local suite folder status=0
    suite=$(os_field VERSION_CODENAME)
    folder=$(mktemp -d)
    if ! write_sources_with_backports "$folder" "$suite"; then
        rm -rf -- "$folder"
        die "no apt source of this machine names the suite $suite, from which the entry for $suite-backports is derived." \
            "Add $suite-backports to the apt sources, then run this again; wanted from there: $*."
    fi
    refresh_apt_index -o "Dir::Etc::SourceParts=$folder"
    say "Installing $* from $suite-backports ..."
    apt_get_as_root install --no-install-recommends -o "Dir::Etc::SourceParts=$folder" -t "$suite-backports" "$@" ||
        status=$?
    rm -rf -- "$folder"
    [[ $status -eq 0 ]] || die "apt-get could not install $* from $suite-backports; its message is above."
}

# Fills FOLDER with the machine's own source files and, where none of them has SUITE-backports, with one more that is
# made from the machine's entry for SUITE.
write_sources_with_backports() { # FOLDER SUITE
    local folder=$1 suite=$2 file derived backports=missing
    while read -r file; do
        [[ $file == "$APT_ETC/sources.list" ]] || ln -s -- "$file" "$folder/"
        [[ -z $(sources_as "$file" "$suite-backports" "$suite-backports") ]] || backports=present
    done < <(apt_source_files)
    while read -r file && [[ $backports == missing ]]; do
        derived=$(sources_as "$file" "$suite" "$suite-backports")
        [[ -n $derived ]] || continue
        printf '%s\n' "$derived" >"$folder/nephroid-backports.${file##*.}"
        backports=derived
    done < <(apt_source_files)
    [[ $backports != missing ]]
}

apt_source_files() {
    local file
    for file in "$APT_ETC"/sources.list "$APT_ETC"/sources.list.d/*.list "$APT_ETC"/sources.list.d/*.sources; do
        [[ ! -r $file ]] || printf '%s\n' "$file"
    done
}

# Prints the active binary sources of FILE that carry suite FROM, reduced to that suite and with it renamed to TO. Mirror,
# components, key and every other option stay as the machine has them.
sources_as() { # FILE FROM TO
    case $1 in
    *.sources) deb822_sources_as "$@" ;;
    *) one_line_sources_as "$@" ;;
    esac
}

one_line_sources_as() { # FILE FROM TO
    awk -v from="$2" -v to="$3" '
        $1 == "deb" {
            uri = 2
            if ($2 ~ /^\[/) { while (uri < NF && $uri !~ /\]$/) uri++; uri++ }
            if ($(uri + 1) == from) { $(uri + 1) = to; print }
        }' "$1"
}

deb822_sources_as() { # FILE FROM TO
    awk -v from="$2" -v to="$3" '
        function start_stanza() { is_binary = has_suite = 0; is_enabled = 1; kept = field = "" }
        function end_stanza() {
            if (is_binary && has_suite && is_enabled) printf "Types: deb\nSuites: %s\n%s\n", to, kept
            start_stanza()
        }
        BEGIN { start_stanza() }
        /^#/ { next }
        /^[ \t]*$/ { end_stanza(); next }
        {
            value = $0
            if ($0 ~ /^[^ \t]/) {
                field = tolower($0)
                sub(/[ \t]*:.*/, "", field)
                sub(/^[^:]*:/, "", value)
            }
            count = split(value, words)
            for (i = 1; i <= count; i++) {
                if (field == "types" && words[i] == "deb") is_binary = 1
                if (field == "suites" && words[i] == from) has_suite = 1
                if (field == "enabled" && tolower(words[i]) ~ /^(no|false|off|without|disable|0)$/) is_enabled = 0
            }
            if (field != "types" && field != "suites" && field != "enabled") kept = kept $0 "\n"
        }
        END { end_stanza() }' "$1"
}
