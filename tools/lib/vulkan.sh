# shellcheck shell=bash
# Finds Vulkan drivers without asking Vulkan, and brings in what is missing. Sourced after apt.sh, never run.

DEV=/dev
SYS=/sys
CACHE=${XDG_CACHE_HOME:-$HOME/.cache}/nephroid
SWIFTSHADER_ICD=$CACHE/swiftshader/vk_swiftshader_icd.json
OLD_LAVAPIPE_ICD=$CACHE/lavapipe-old/lvp_icd.json

# Ray queries on lavapipe: present in 25.0.7, absent in 24.0.5 and in Debian 12's own 22.3.
MESA_WITH_RAY_QUERIES=25

library_path_of() { # NAME: where the dynamic linker finds it; empty where it does not
    local tag
    case $(uname -m) in
    x86_64) tag=x86-64 ;;
    aarch64) tag=AArch64 ;;
    *) tag=libc6 ;;
    esac
    PATH=$PATH:/usr/sbin:/sbin ldconfig -p 2>/dev/null |
        awk -v name="$1" -v tag="$tag" '$1 == name && index($2, tag) && !found++ { print $NF }'
}

has_loader() { [[ -n $(library_path_of libvulkan.so.1) ]]; }

icd_files() { # the driver manifests that the Vulkan loader would read
    local chosen=${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}} entry entries
    entries=(/etc/vulkan/icd.d "${XDG_DATA_HOME:-$HOME/.local/share}/vulkan/icd.d"
        /usr/local/share/vulkan/icd.d /usr/share/vulkan/icd.d)
    [[ -z $chosen ]] || IFS=: read -r -a entries <<<"$chosen"
    for entry in "${entries[@]}"; do
        if [[ -d $entry ]]; then
            find -L "$entry" -maxdepth 1 -type f -name '*.json' | sort
        elif [[ -f $entry ]]; then
            printf '%s\n' "$entry"
        fi
    done
}

icd_library() { # ICD: the library that it names, as a path; empty where there is no such file
    local named path
    named=$(sed -n '/"library_path"/{s/.*"library_path"[[:space:]]*:[[:space:]]*"\([^"]*\)".*/\1/p;q}' "$1")
    case $named in
    /*) path=$named ;;
    */*) path=$(dirname -- "$1")/$named ;;
    *) path=$(library_path_of "$named") ;;
    esac
    [[ ! -f $path ]] || printf '%s\n' "$path"
}

# The loader skips a driver for another architecture, or one whose own libraries are absent, without a word. ldd sees both.
icd_loads() { # ICD
    local library needs
    library=$(icd_library "$1")
    [[ -n $library ]] && needs=$(ldd "$library" 2>/dev/null) && [[ $needs != *'not found'* ]]
}

icd_is_software() { # ICD
    case $(icd_library "$1") in
    *libvulkan_lvp* | *libvk_swiftshader*) return 0 ;;
    *) return 1 ;;
    esac
}

has_render_node_of() { # PCI VENDOR ID, empty for any
    local node
    for node in "$DEV"/dri/renderD*; do
        [[ -e $node ]] || continue
        [[ -n $1 ]] || return 0
        [[ $(cat -- "$SYS/class/drm/${node##*/}/device/vendor" 2>/dev/null) != "$1" ]] || return 0
    done
    return 1
}

# Mesa's package brings a manifest for every GPU it knows, so a manifest alone shows no GPU.
icd_has_device() { # ICD
    case $(icd_library "$1") in
    *libvulkan_lvp* | *libvk_swiftshader*) return 0 ;;
    *nvidia*) compgen -G "$DEV/nvidia[0-9]*" >/dev/null ;;
    *intel*) has_render_node_of 0x8086 ;;
    *radeon* | *amdvlk*) has_render_node_of 0x1002 ;;
    *nouveau*) has_render_node_of 0x10de ;;
    *virtio* | *gfxstream*) has_render_node_of 0x1af4 ;;
    *dzn*) [[ -e $DEV/dxg ]] ;;
    *) has_render_node_of '' ;;
    esac
}

usable_icds() {
    local icd
    while read -r icd; do
        if icd_loads "$icd" && icd_has_device "$icd"; then printf '%s\n' "$icd"; fi
    done < <(icd_files)
}

lavapipe_icd() { # lavapipe's manifest, wherever VK_DRIVER_FILES points; empty where it is not installed
    local icd
    while read -r icd; do
        if [[ $(icd_library "$icd") == *libvulkan_lvp* ]] && icd_loads "$icd"; then printf '%s\n' "$icd"; fi
    done < <(VK_DRIVER_FILES='' VK_ICD_FILENAMES='' icd_files) | sed -n 1p
}

has_swiftshader() { [[ -f $SWIFTSHADER_ICD ]] && icd_loads "$SWIFTSHADER_ICD"; }

# NAME=MANIFEST pairs joined by colons. A GPU's driver is named after its manifest, and may still find no device it likes.
test_drivers() {
    local icd name drivers=()
    icd=$(lavapipe_icd)
    [[ -z $icd ]] || drivers+=("lavapipe=$icd")
    ! has_swiftshader || drivers+=("swiftshader=$SWIFTSHADER_ICD")
    while read -r icd; do
        name=$(basename -- "$icd" .json)
        icd_is_software "$icd" || drivers+=("${name%%_icd*}=$icd")
    done < <(usable_icds)
    local IFS=:
    printf '%s\n' "${drivers[*]}"
}

want_loader() { has_loader || want libvulkan1; }

want_software_driver() {
    if is_debian_12; then
        installed_version_is_at_least mesa-vulkan-drivers "$MESA_WITH_RAY_QUERIES" || want_from_backports mesa-vulkan-drivers
    elif [[ -z $(lavapipe_icd) ]]; then
        want mesa-vulkan-drivers
    fi
}

bring_in_demo_needs() {
    want_loader
    [[ -n $(usable_icds) ]] || want_software_driver
    bring_in_wanted
}

# No package asks for the X libraries: the window library loads them by name at run time.
bring_in_test_needs() {
    want_loader
    want_software_driver
    want vulkan-validationlayers shellcheck xvfb xauth \
        libx11-6 libx11-xcb1 libxcursor1 libxi6 libxrandr2 libxkbcommon-x11-0
    bring_in_wanted
    has_swiftshader || bring_in_swiftshader
    has_old_lavapipe || bring_in_old_lavapipe
}

# Debian packages SwiftShader only with chromium; two files of it are taken, and chromium is not installed.
bring_in_swiftshader() {
    local scratch status=0
    if [[ $(os_field ID) != debian ]] || ! have apt-get; then
        say "SwiftShader is skipped: its driver is taken out of Debian's chromium package, and this is not Debian."
        return 0
    fi
    if can_be_root; then refresh_apt_index; fi
    say "Fetching SwiftShader's driver out of Debian's chromium package ..."
    scratch=$(mktemp -d)
    unpack_swiftshader "$scratch" && keep_swiftshader "$scratch/usr/lib/chromium" || status=$?
    rm -rf -- "$scratch"
    [[ $status -eq 0 ]] || die "SwiftShader's driver could not be taken out of Debian's chromium package; the reason is above." \
        "Without root, 'apt-get update' may have to be run as root first."
}

unpack_swiftshader() { # SCRATCH
    local package
    # With chromium 156 the first of them holds the driver; the second is tried because it moves with chromium's packaging.
    for package in chromium-common chromium; do
        (cd -- "$1" && apt-get "${APT_OPTIONS[@]}" -o APT::Sandbox::User=root download "$package") >&2 || continue
        dpkg-deb --fsys-tarfile "$1/$package"_*.deb |
            tar -x -C "$1" ./usr/lib/chromium/libvk_swiftshader.so ./usr/lib/chromium/vk_swiftshader_icd.json &&
            return 0
    done
    return 1
}

keep_swiftshader() { # FOLDER that holds the two files
    local library=${SWIFTSHADER_ICD%/*}/libvk_swiftshader.so
    # The manifest comes last: with it, SwiftShader counts as complete.
    mkdir -p -- "${SWIFTSHADER_ICD%/*}" &&
        cp -- "$1/libvk_swiftshader.so" "$library.partial" &&
        mv -- "$library.partial" "$library" &&
        sed "s|\"library_path\"[^,}]*|\"library_path\": \"$library\"|" "$1/vk_swiftshader_icd.json" >"$SWIFTSHADER_ICD.partial" &&
        mv -- "$SWIFTSHADER_ICD.partial" "$SWIFTSHADER_ICD"
}

has_old_lavapipe() { [[ -f $OLD_LAVAPIPE_ICD ]] && icd_loads "$OLD_LAVAPIPE_ICD"; }

# Debian 12's own Mesa beside the one from backports: two files of its package are taken, and nothing is installed. The tests
# can do without it, so whatever stands in the way is told and no more.
bring_in_old_lavapipe() {
    local scratch status=0
    if ! is_debian_12 || ! have apt-get; then
        say "Debian 12's own lavapipe is skipped: this is not Debian 12."
        return 0
    fi
    if can_be_root; then refresh_apt_index; fi
    say "Fetching lavapipe out of Debian 12's own mesa-vulkan-drivers ..."
    scratch=$(mktemp -d)
    unpack_old_lavapipe "$scratch" && keep_old_lavapipe "$scratch" || status=$?
    rm -rf -- "$scratch"
    [[ $status -eq 0 ]] || say "Debian 12's own lavapipe is skipped: its package could not be had; the reason is above."
}

unpack_old_lavapipe() { # SCRATCH
    (cd -- "$1" &&
        apt-get "${APT_OPTIONS[@]}" -o APT::Sandbox::User=root download "mesa-vulkan-drivers/$(os_field VERSION_CODENAME)") >&2 &&
        dpkg-deb --fsys-tarfile "$1"/mesa-vulkan-drivers_*.deb |
        tar -x -C "$1" --wildcards '*/libvulkan_lvp.so' '*/lvp_icd.*.json'
}

keep_old_lavapipe() { # FOLDER that the package's files lie in
    local folder=${OLD_LAVAPIPE_ICD%/*} library manifest
    library=$(find "$1" -name libvulkan_lvp.so | sed -n 1p)
    manifest=$(find "$1" -name 'lvp_icd.*.json' | sed -n 1p)
    # The manifest comes last: with it, the driver counts as complete.
    [[ -n $library && -n $manifest ]] && mkdir -p -- "$folder" &&
        cp -- "$library" "$folder/libvulkan_lvp.so.partial" &&
        mv -- "$folder/libvulkan_lvp.so.partial" "$folder/libvulkan_lvp.so" &&
        sed "s|\"library_path\"[^,}]*|\"library_path\": \"$folder/libvulkan_lvp.so\"|" "$manifest" >"$OLD_LAVAPIPE_ICD.partial" &&
        mv -- "$OLD_LAVAPIPE_ICD.partial" "$OLD_LAVAPIPE_ICD"
}
