#!/bin/bash
# The newcomer's way, on a Debian 12 that holds nothing but git and make: make demo and make test, twice each.
#   scripts/fresh-debian.sh DIRECTORY [TARGET...]
# Needs root and debootstrap. DIRECTORY must not exist yet; remove it afterwards. Takes the work tree as it is now.
# FURROW_DATA=DIR, if set, is copied beside it, so that the tests on real logs run as well.
set -euo pipefail
cd "$(dirname "$0")/.."

root=${1:?usage: scripts/fresh-debian.sh DIRECTORY [TARGET...]}
shift
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(demo demo test test)
if [ -e "$root" ]; then
	echo "fresh-debian: $root exists; give a new directory" >&2
	exit 2
fi

# The host's mirror and its way to the network.
mirror=$(sed -nE 's/^(URIs:|deb) +(\[[^]]*\] +)?([a-z]+:[^ ]*\/debian\/?)( .*)?$/\3/p' \
	/etc/apt/sources.list.d/debian.sources /etc/apt/sources.list 2>/dev/null | head -n 1) || true
debootstrap --variant=minbase --include=git,make bookworm "$root" "${mirror:-http://deb.debian.org/debian}"
install -D /etc/resolv.conf "$root/etc/resolv.conf"
install -D /etc/ssl/certs/ca-certificates.crt "$root/root/host-certificates.crt"
for file in $(grep -lsi proxy /etc/apt/apt.conf /etc/apt/apt.conf.d/* || true); do
	install -D "$file" "$root$file"
done

mkdir -p "$root/root/furrow"
git ls-files -z --cached --others --exclude-standard | tar -c --null -T - | tar -x --no-same-owner -C "$root/root/furrow"
if [ -n "${FURROW_DATA:-}" ]; then
	mkdir -p "$root/root/shared"
	cp -r "$FURROW_DATA" "$root/root/shared/data"
fi

mount -t proc proc "$root/proc"
trap 'umount "$root/proc"' EXIT

for target in "${targets[@]}"; do
	begin=$SECONDS
	env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin ${http_proxy:+http_proxy="$http_proxy"} \
		${https_proxy:+https_proxy="$https_proxy"} PIP_CERT=/root/host-certificates.crt \
		chroot "$root" make -C /root/furrow "$target"
	echo "fresh-debian: make $target: $((SECONDS - begin)) s"
done
