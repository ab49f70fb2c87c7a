#!/bin/sh
# setup.sh: installs the Debian packages that the build, the demo and the tests need and that are missing. Changes nothing,
# and needs no privileges, where all are there.
set -eu
packages="gcc g++ make libc6-dev libvulkan-dev libvulkan1 libvulkan-volk-dev mesa-vulkan-drivers vulkan-validationlayers glslang-tools glslc
spirv-tools libopenexr-dev libpng-dev libembree-dev libassimp-dev libcmocka-dev glmark2-data"

if ! command -v dpkg-query > /dev/null; then
    echo "setup: not a Debian system; install the counterparts of: $(echo "$packages" | tr '\n' ' ')" >&2
    exit 0
fi

missing=
for package in $packages; do
    case $(dpkg-query -W -f '${db:Status-Status}' "$package" 2> /dev/null || true) in
        installed*) ;;
        *) missing="$missing $package" ;;
    esac
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
    if command -v sudo > /dev/null; then
        as_root=sudo
    else
        echo "setup: neither root nor sudo; as root run: apt-get install$missing" >&2
        exit 1
    fi
fi
echo "setup: installing$missing"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
install() {
    # shellcheck disable=SC2086 # a list of words
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing > "$log" 2>&1
}
install || { $as_root apt-get update -q > "$log" 2>&1 && install; } || {
    cat "$log" >&2
    echo "setup: could not install; as root run: apt-get install$missing" >&2
    exit 1
}
