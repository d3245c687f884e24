#!/bin/sh
# Install the Debian packages that a task needs, if they are missing.
#   scripts/packages.sh build|test|bench|check ...
# As root or with sudo; elsewhere the command to type is printed and the exit status is 1.
set -eu

packages=
for task in "$@"; do
	case $task in
	build) packages="$packages gcc libc6-dev make cmake pkg-config zlib1g-dev libinih-dev liblcm-dev liblcm-bin
		libglib2.0-dev libcmocka-dev gnuplot-nox" ;;
	test) packages="$packages python3-venv rtklib gdal-bin mandoc" ;;
	bench) packages="$packages valgrind" ;;
	check) packages="$packages clang libclang-rt-14-dev llvm-14 clang-format cppcheck lcov" ;;
	*) echo "packages.sh: unknown task $task" >&2 && exit 2 ;;
	esac
done

if ! command -v dpkg-query >/dev/null; then
	echo "furrow: not a Debian system; these packages or their likes are needed:" $packages >&2
	exit 0
fi

installed=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' $packages 2>/dev/null | sed -n 's/^installed //p') || true
missing=
for package in $packages; do
	case "
$installed
" in
	*"
$package
"*) ;;
	*) missing="$missing $package" ;;
	esac
done
[ -n "$missing" ] || exit 0

echo "furrow: missing Debian packages:$missing"
if [ "$(id -u)" = 0 ]; then
	root=env
elif command -v sudo >/dev/null && { [ -t 0 ] || sudo -n true 2>/dev/null; }; then
	root="sudo env"
else
	echo "furrow: please install them as root, then run make again:" >&2
	echo "    apt-get install --no-install-recommends$missing" >&2
	exit 1
fi
echo "furrow: installing them"
$root apt-get update -qq || echo "furrow: apt-get update failed; trying with the lists that are there" >&2
$root DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
