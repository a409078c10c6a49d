# shellcheck shell=bash
# Something to draw with where there is no GPU and no display: a software Vulkan driver and a virtual X display.
#
# Sourced by demo.sh and test.sh, which call `need_compiler`, `need_vulkan` and `need_virtual_display`.
# Each looks first, returns at once when nothing is missing, and brings the rest by apt; where there is no apt, or
# apt fails, it says what is missing and ends the script with status 1.

# Mesa's layer that chooses among devices asks for a desktop session and, where there is none, prints "error:
# XDG_RUNTIME_DIR is invalid" in the middle of our output. Nothing here needs the layer, so it stays out.
export NODEVICE_SELECT=1

# Ends the script with a message.
give_up() {
    printf 'error: %s\n' "$*" >&2
    exit 1
}

on_linux() {
    [[ $(uname -s) == Linux ]]
}

# Whether the dynamic linker knows a library, such as libvulkan.so.1.
has_library() {
    local known
    # ldconfig lies outside the PATH of ordinary users on Debian.
    known=$(PATH="$PATH:/usr/sbin:/sbin" ldconfig -p 2>/dev/null || true)
    [[ $known == *"$1"* ]]
}

# Installs packages: $1 says what for, the rest are their names on Debian and Ubuntu.
bring() {
    local purpose=$1
    shift
    command -v apt-get >/dev/null ||
        give_up "$purpose is missing and this system has no apt; install what your system calls: $*"
    local as_root=()
    if [[ $(id -u) != 0 ]]; then
        command -v sudo >/dev/null || give_up "$purpose is missing; as root, run: apt-get install $*"
        as_root=(sudo)
    fi
    printf '%s is missing; installing by apt: %s\n' "$purpose" "$*" >&2
    # A stale list of packages is often good enough, so a failed update alone does not end the script.
    "${as_root[@]}" apt-get update -qq </dev/null ||
        printf 'warning: apt-get update failed; trying with the lists at hand\n' >&2
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends "$@" </dev/null >/dev/null ||
        give_up "$purpose could not be installed; run this yourself and start again: apt-get install $*"
}

# Whether a Vulkan driver is installed that can run here: a software one, or any one beside a device node.
has_vulkan_driver() {
    # Whoever names a driver has chosen it.
    [[ -n ${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-} ]] && return 0
    local file device=no driver=no
    for file in /dev/dri/renderD* /dev/nvidia[0-9]* /dev/dxg /dev/mali*; do
        [[ -e $file ]] && device=yes
    done
    for file in {/usr/share,/usr/local/share,/etc}/vulkan/icd.d/*.json; do
        [[ -e $file ]] || continue
        driver=yes
        case ${file##*/} in
            lvp_* | *swiftshader*) return 0 ;;
        esac
    done
    [[ $device == yes && $driver == yes ]]
}

# The linker that rustc calls, and a compiler for the C++ of meshoptimizer, which the benches compare with.
need_compiler() {
    command -v cargo >/dev/null || {
        # A fresh rustup is on the PATH of the next login only.
        # shellcheck disable=SC1091
        [[ -r ${CARGO_HOME:-$HOME/.cargo}/env ]] && . "${CARGO_HOME:-$HOME/.cargo}/env"
    }
    command -v cargo >/dev/null || give_up "cargo is missing; install Rust from https://rustup.rs"
    on_linux || return 0
    command -v cc >/dev/null || bring "a C compiler, whose linker rustc needs," gcc libc6-dev
    command -v c++ >/dev/null || bring "a C++ compiler" g++ libc6-dev
}

# A Vulkan loader and driver; macOS and Windows have a graphics interface of their own.
need_vulkan() {
    on_linux || return 0
    if ! has_library libvulkan.so.1 || ! has_vulkan_driver; then
        bring "a Vulkan driver" libvulkan1 mesa-vulkan-drivers
    fi
}

# A display for tests of the window: xvfb-run, and the libraries that a window loads when it opens.
need_virtual_display() {
    on_linux || return 0
    local missing=()
    command -v xvfb-run >/dev/null || missing+=(xvfb)
    command -v xauth >/dev/null || missing+=(xauth)
    has_library libX11-xcb.so.1 || missing+=(libx11-xcb1)
    has_library libXcursor.so.1 || missing+=(libxcursor1)
    has_library libXi.so.6 || missing+=(libxi6)
    has_library libxkbcommon-x11.so.0 || missing+=(libxkbcommon-x11-0)
    if ((${#missing[@]})); then
        bring "a virtual display" "${missing[@]}"
    fi
}
