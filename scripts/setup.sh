# shellcheck shell=bash
# What the build needs and cargo cannot bring: a recent Rust, a linker and, on Linux, a Vulkan
# driver. Sourced, from the root of the repository, by the scripts beside it, which call `setup`.
# It changes the system in two cases only, both on Linux: without any Vulkan driver it gets Mesa's software
# one, because the tests and examples render; and `scripts/test` installs the headers that Bevy's default
# features need, where it may do so without asking.

# The oldest compiler that is known to compile Bevy, whatever Bevy itself declares.
OLDEST_RUST=1.95
# What every cargo command that compiles is given; filled by `check_rust`. Bash before 4.4 takes an
# empty array for an unset variable, hence ${CARGO_FLAGS[@]+"${CARGO_FLAGS[@]}"}.
CARGO_FLAGS=()

# Where the dynamic linker finds libraries, beside LD_LIBRARY_PATH and its own cache.
LIBRARY_DIRS=(
    /usr/local/lib /usr/local/lib64 /usr/lib /usr/lib64 /lib /lib64
    "/usr/lib/$(uname -m)-linux-gnu" "/lib/$(uname -m)-linux-gnu"
    /run/opengl-driver/lib /run/current-system/sw/lib
)

# Where drivers announce themselves to the Vulkan loader, beside the user's XDG folders.
DRIVER_DIRS=(
    /etc/vulkan/icd.d /usr/local/etc/vulkan/icd.d
    /usr/local/share/vulkan/icd.d /usr/share/vulkan/icd.d
    /run/opengl-driver/share/vulkan/icd.d
)

# Ends the script: die "what is wrong" "remedy line"...
die() {
    printf '\nerror: %s\n' "$1" >&2
    shift
    if [ $# -gt 0 ]; then printf '  %s\n' "$@" >&2; fi
    exit 1
}

has() { command -v "$1" >/dev/null 2>&1; }

operating_system() {
    case "$(uname -s)" in
        Linux*) echo linux ;;
        Darwin*) echo macos ;;
        MINGW* | MSYS* | CYGWIN*) echo windows ;;
        *) echo other ;;
    esac
}

# --- Rust and the linker -------------------------------------------------------------------------

check_rust() {
    # rustup adds itself to the profile, which the shell that ran it and many CI jobs have not read.
    local cargo_bin="${CARGO_HOME:-${HOME:-}/.cargo}/bin"
    if ! has cargo && [ -x "$cargo_bin/cargo" ]; then PATH="$cargo_bin:$PATH"; fi

    local declared
    declared=$(sed -n 's/^rust-version = "\(.*\)"$/\1/p' Cargo.toml)
    has cargo || die "cargo was not found: Rust $declared or later is needed." \
        "Install it from https://rustup.rs, open a new terminal and run this again."
    local version
    version=$(rustc --version 2>/dev/null) || die "rustc does not run: Rust $declared or later is needed." \
        "With rustup: rustup default stable" \
        "Otherwise install Rust from https://rustup.rs."
    version_at_least "${version#rustc }" "$OLDEST_RUST" || die \
        "$version is too old: Rust $declared or later is needed." \
        "With rustup: rustup update stable && rustup default stable" \
        "Otherwise install Rust from https://rustup.rs; a distribution's own is often older."
    if ! version_at_least "${version#rustc }" "$declared"; then
        echo "$version is older than the $declared that Bevy declares, but compiles it: passing --ignore-rust-version to cargo."
        CARGO_FLAGS=(--ignore-rust-version)
    fi
}

# version_at_least "1.97.0-nightly (...)" "1.95": compares major, minor and patch.
version_at_least() {
    local have wanted part
    IFS=. read -r -a have <<<"${1%%[!0-9.]*}"
    IFS=. read -r -a wanted <<<"$2"
    for part in 0 1 2; do
        if [ "${have[part]:-0}" -ne "${wanted[part]:-0}" ]; then
            [ "${have[part]:-0}" -gt "${wanted[part]:-0}" ]
            return
        fi
    done
}

check_linker() {
    case "$(operating_system)" in
        windows) return ;; # rustc looks for Visual Studio itself and names what is missing.
        macos) # /usr/bin/cc exists without the tools, as a stub that offers to install them.
            if xcode-select -p >/dev/null 2>&1; then return; fi
            die "no C linker: Rust links with Apple's command-line tools." \
                "Install them: xcode-select --install"
            ;;
    esac
    if has cc; then return; fi
    local command="install gcc or clang with your system's package manager, so that \`cc\` runs"
    case "$(package_manager)" in
        apt-get) command="apt-get update && apt-get install -y gcc libc6-dev" ;;
        zypper) command="zypper install -y gcc" ;;
        dnf) command="dnf install -y gcc" ;;
        yum) command="yum install -y gcc" ;;
        pacman) command="pacman -S gcc" ;;
        apk) command="apk add gcc musl-dev" ;;
    esac
    die "no C linker: \`cc\` was not found, and Rust links with it." "As root: $command"
}

# --- Vulkan --------------------------------------------------------------------------------------

check_vulkan() {
    [ "$(operating_system)" = linux ] || return 0 # macOS has Metal, Windows Direct3D 12.
    local missing
    missing=$(vulkan_missing)
    if [ -z "$missing" ]; then return; fi

    local variable value
    for variable in VK_DRIVER_FILES VK_ICD_FILENAMES; do
        value="${!variable:-}"
        if [ -n "$value" ] && [[ "$missing" == *driver* ]]; then
            die "$variable names no Vulkan driver that exists here: $value" \
                "Correct it, or unset it so that the installed drivers are found."
        fi
    done

    echo "No Vulkan here: $missing not found. Mesa's software driver is needed (it runs on the CPU)."
    install_software_driver
    missing=$(vulkan_missing)
    [ -z "$missing" ] || die "the installation ended without an error, but $missing still cannot be found." \
        "If the driver lies in an unusual place, name its manifest: export VK_DRIVER_FILES=/path/to/lvp_icd.json"
}

# Names what is not there; prints nothing where the loader and a driver are.
vulkan_missing() {
    local missing=''
    library_exists libvulkan.so.1 || missing='the loader (libvulkan.so.1)'
    driver_exists || missing="${missing:+$missing and }a driver (icd.d/*.json)"
    printf '%s' "$missing"
}

# library_exists NAME_OR_PATH, of this processor: 32-bit libraries are common beside 64-bit ones.
library_exists() {
    local dir name abi
    case "$1" in /*) [ -e "$1" ]; return ;; esac

    local library_path
    IFS=: read -r -a library_path <<<"${LD_LIBRARY_PATH:-}"
    for dir in ${library_path[@]+"${library_path[@]}"} "${LIBRARY_DIRS[@]}"; do
        if [ -n "$dir" ] && [ -e "$dir/$1" ]; then return 0; fi
    done

    local abi_of_machine=''
    case "$(uname -m)" in
        x86_64) abi_of_machine=x86-64 ;;
        aarch64) abi_of_machine=AArch64 ;;
    esac
    while read -r name abi _; do
        if [ "$name" = "$1" ] && [[ "$abi" == *"$abi_of_machine"* ]]; then return 0; fi
    done < <(PATH="$PATH:/usr/sbin:/sbin" ldconfig -p 2>/dev/null)
    return 1
}

# Searches as the Vulkan loader does: VK_DRIVER_FILES (formerly VK_ICD_FILENAMES) replaces the
# folders, VK_ADD_DRIVER_FILES adds to them.
driver_exists() {
    local only="${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" places=() dirs=() place
    if [ -n "$only" ]; then
        IFS=: read -r -a places <<<"$only"
    else
        IFS=: read -r -a places <<<"${VK_ADD_DRIVER_FILES:-}"
        local home="${HOME:-/nonexistent}"
        IFS=: read -r -a dirs <<<"${XDG_CONFIG_DIRS:-}:${XDG_DATA_DIRS:-}"
        dirs+=("${XDG_CONFIG_HOME:-$home/.config}" "${XDG_DATA_HOME:-}" "$home/.local/share")
        for place in "${dirs[@]}"; do
            if [ -n "$place" ]; then places+=("$place/vulkan/icd.d"); fi
        done
        places+=("${DRIVER_DIRS[@]}")
    fi
    local manifest
    for place in "${places[@]}"; do
        if [ -f "$place" ]; then
            if is_driver_manifest "$place"; then return 0; fi
        elif [ -d "$place" ]; then
            for manifest in "$place"/*.json; do
                if is_driver_manifest "$manifest"; then return 0; fi
            done
        fi
    done
    return 1
}

# A manifest outlives a driver that was removed, so the library it names is looked for as well.
is_driver_manifest() {
    [ -r "$1" ] || return 1
    case "$(uname -m):$1" in x86_64:*.i[3-6]86.json) return 1 ;; esac
    local library
    library=$(sed -n 's/.*"library_path"[[:space:]]*:[[:space:]]*"\([^"]*\)".*/\1/p' "$1")
    case "$library" in
        '') return 1 ;;
        /*) ;;
        */*) library="$(cd -- "$(dirname -- "$1")" && pwd)/$library" ;;
    esac
    library_exists "$library"
}

install_software_driver() {
    local manager
    manager=$(package_manager)
    [ -n "$manager" ] || die "no package manager that this script knows (apt-get, dnf, yum, pacman, zypper, apk)." \
        "Install the Vulkan loader (libvulkan.so.1) and Mesa's software driver (lavapipe, lvp_icd.*.json) by hand." \
        "NixOS: hardware.graphics.enable = true, and vulkan-loader's lib folder in LD_LIBRARY_PATH."

    local prefix
    prefix=$(root_prefix) || die \
        "installing it needs root, and sudo is missing or would ask for a password without a terminal." \
        "Run this, then run the script again:" \
        "  $(software_driver_command "$manager" 'sudo ')"

    local command
    command=$(software_driver_command "$manager" "$prefix")
    echo "Installing it${prefix:+ with sudo, which may ask for your password}:"
    echo "  $command"
    sh -c "$command" || die "the installation failed; its own message is above." \
        "Once that is solved (often: no network, or another installation is running), run the command above by hand."
}

# --- Headers for Bevy's default features ---------------------------------------------------------

# Whether a game with Bevy's default features can be linked here; tries to install what it needs.
game_libraries() {
    [ "$(operating_system)" = linux ] || return 0
    if game_libraries_exist; then return 0; fi
    local prefix command
    prefix=$(root_prefix) || return 1
    command=$(game_libraries_command "$(package_manager)" "$prefix")
    if [ -z "$command" ]; then return 1; fi
    echo "Installing the headers of ALSA, udev and Wayland, which Bevy's default features need:"
    echo "  $command"
    sh -c "$command" >/dev/null && game_libraries_exist
}

game_libraries_exist() {
    has pkg-config && pkg-config --exists alsa libudev wayland-client
}

# game_libraries_command MANAGER PREFIX, as Bevy's page on Linux names them.
game_libraries_command() {
    case "$1" in
        apt-get)
            printf '%s' "${2}apt-get update && ${2}env DEBIAN_FRONTEND=noninteractive" \
                " apt-get install -y --no-install-recommends pkg-config libasound2-dev libudev-dev libwayland-dev"
            ;;
        zypper) echo "${2}zypper --non-interactive install pkg-config alsa-devel libudev-devel wayland-devel" ;;
        dnf | yum) echo "${2}$1 install -y pkgconf-pkg-config alsa-lib-devel systemd-devel wayland-devel" ;;
        pacman) echo "${2}pacman -S --noconfirm --needed pkgconf alsa-lib systemd-libs wayland" ;;
        apk) echo "${2}apk add pkgconf alsa-lib-dev eudev-dev wayland-dev" ;;
    esac
}

package_manager() {
    local manager
    for manager in apt-get zypper dnf yum pacman apk; do
        if has "$manager"; then
            echo "$manager"
            return
        fi
    done
}

# What makes a command run as root: nothing or "sudo "; fails where neither would work.
root_prefix() {
    if [ "$(id -u)" -eq 0 ]; then return 0; fi
    has sudo || return 1
    sudo -n true 2>/dev/null || [ -t 0 ] || return 1
    echo "sudo "
}

# software_driver_command MANAGER PREFIX: the loader and Mesa's driver under each one's names.
software_driver_command() {
    case "$1" in
        apt-get)
            printf '%s' "${2}apt-get update && ${2}env DEBIAN_FRONTEND=noninteractive" \
                " apt-get install -y --no-install-recommends mesa-vulkan-drivers libvulkan1"
            ;;
        zypper) echo "${2}zypper --non-interactive install libvulkan_lvp libvulkan1" ;;
        dnf | yum) echo "${2}$1 install -y mesa-vulkan-drivers vulkan-loader" ;;
        pacman) # A container starts without package databases; elsewhere -y would be half an upgrade.
            local sync='-S'
            if ! compgen -G '/var/lib/pacman/sync/*.db' >/dev/null; then sync='-Sy'; fi
            echo "${2}pacman $sync --noconfirm --needed vulkan-swrast vulkan-icd-loader"
            ;;
        apk) echo "${2}apk add mesa-vulkan-swrast vulkan-loader" ;;
    esac
}

# --- For the scripts -----------------------------------------------------------------------------

# Whether Bevy has been compiled for the profile that every script uses.
bevy_is_built() {
    compgen -G "${CARGO_TARGET_DIR:-target}/release/deps/libbevy_internal-*.rlib" >/dev/null
}

# Says what a first run is in for; says nothing once Bevy is there.
announce_first_build() {
    if bevy_is_built; then return; fi
    echo "The first run compiles Bevy: about 15 minutes on 2 cores, less with more. Later runs reuse it."
}

# Without a runtime folder, as in most containers, every start of the driver prints an error.
provide_runtime_folder() {
    if [ "$(uname -s)" = Linux ] && [ -z "${XDG_RUNTIME_DIR:-}" ]; then
        mkdir -p -m 700 target/runtime
        export XDG_RUNTIME_DIR="$PWD/target/runtime"
    fi
}

# Sets `on_driver`, a prefix for commands that draw. Where there is no GPU and nobody has chosen a driver, that is
# the software driver of Mesa 25, which `scripts/gpu-static setup` unpacks into a folder of the cache: it takes about
# half the time of Debian's Mesa 22 once its shaders are in the cache, and binds more textures. Where it cannot be
# unpacked, the system's driver draws.
choose_driver() {
    on_driver=()
    [ "$(operating_system)" = linux ] || return 0
    if [ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] || compgen -G '/dev/dri/renderD*' >/dev/null; then return; fi
    if has apt-get && ! scripts/gpu-static check >/dev/null 2>&1; then
        echo "Unpacking the software driver of Mesa 25 into the cache (12 MB)."
        scripts/gpu-static setup >/dev/null 2>&1 || echo "It is not to be had here: the system's driver draws."
    fi
    if scripts/gpu-static software true 2>/dev/null; then on_driver=(scripts/gpu-static software); fi
}

setup() {
    # With stdin closed the next file opened would take its place; package managers misread that.
    if ! { true 3<&0; } 2>/dev/null; then exec </dev/null; fi
    check_rust
    check_linker
    check_vulkan
    choose_driver
    provide_runtime_folder
}
