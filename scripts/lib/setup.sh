# shellcheck shell=bash
# Preparation shared by the scripts: system packages, Python environment, builds. Sourced, not run.
#
#   root               project root, found from the place of this file
#   ensure_packages    install the missing Debian packages, or say how and stop
#   mirror             the mirror that packages come from
#   try_packages       install packages that are of use but not needed, or say why not and go on
#   ensure_python      make .venv from requirements.txt
#   try_readers        install what tests read exported files with, or go on
#   try_hosts          install programs that the examples of hosts use, and Jupyter, or go on
#   ensure_build       configure and compile a build folder
#   ensure_release     the same for the release build in build/
#
# Each function is silent and instant when there is nothing to do. Messages go to stderr.

set -euo pipefail

root=$(cd -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../.." && pwd -P)
venv=$root/.venv

# Settings of the calling shell that would leak into the project's Python.
unset PYTHONHOME PYTHONPATH PYTHONSTARTUP
export PYTHONNOUSERSITE=1
export MPLBACKEND=Agg
export MPLCONFIGDIR=$venv/matplotlib

# Debian packages that a build needs, and those that the Python environment needs.
build_packages=(
   gfortran gcc libc6-dev meson ninja-build pkg-config
   libgsl-dev libsundials-dev libsundials-fortran-dev libhdf5-dev zlib1g-dev hdf5-tools
   python3 python3-venv git ca-certificates
)
python_packages=(python3 python3-venv ca-certificates)

# Where there is no dpkg, the commands by which some of them are recognised.
declare -A command_of=(
   [gfortran]=gfortran [gcc]=gcc [meson]=meson [ninja-build]=ninja [pkg-config]=pkg-config
   [hdf5-tools]=h5dump [python3]=python3 [git]=git [valgrind]=valgrind
   [chromium]=chromium [slurm-wlm]=slurmctld [munge]=munged [parallel]=parallel
)

say() { printf '%s: %s\n' "$(basename -- "$0")" "$*" >&2; }

die() {
   local status=$1
   shift
   say "$*"
   exit "$status"
}

# Run a command with its output in a log; when it fails, show the end of the log.
# logged LOG COMMAND...
logged() {
   local log=$1 status=0
   shift
   "$@" >"$log" 2>&1 </dev/null || status=$?
   if [ "$status" -ne 0 ]; then
      say "failed with status $status: $*"
      tail -n 60 -- "$log" >&2
      say "the whole log is in $log"
   fi
   return "$status"
}

# Names of those packages that are not installed, one a line.
missing_packages() {
   local installed name
   if command -v dpkg-query >/dev/null; then
      installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "$@" 2>/dev/null || true)
      for name in "$@"; do
         grep -qxF "installed $name" <<<"$installed" || printf '%s\n' "$name"
      done
   else
      for name in "$@"; do
         [ -z "${command_of[$name]-}" ] || command -v "${command_of[$name]}" >/dev/null ||
            printf '%s\n' "$name"
      done
   fi
}

# One attempt at installing; a package list that cannot be refreshed need not matter.
apt_install() {
   "${apt[@]}" update -qq || true
   "${apt[@]}" install -y -qq --no-install-recommends "${missing[@]}"
}

# Set `apt` to the command of the package manager; fails where it may not be used.
find_apt() {
   apt=(env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300)
   [ "$(id -u)" -ne 0 ] || return 0
   command -v sudo >/dev/null && sudo -n true 2>/dev/null || return 1
   apt=(sudo -n "${apt[@]}")
}

# The mirror of the binary packages.
mirror() {
   local found
   found=$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' | grep -v security | head -n 1)
   printf '%s\n' "${found:-http://deb.debian.org/debian}"
}

# Install those packages that are missing, or say how and stop.
need_packages() {
   local missing apt log start=$SECONDS
   mapfile -t missing < <(missing_packages "$@")
   [ ${#missing[@]} -gt 0 ] || return 0
   command -v apt-get >/dev/null ||
      die 2 "install what is missing, here by Debian's names, and run again: ${missing[*]}"
   if ! find_apt; then
      say "these packages are missing; install them and run again:"
      printf 'sudo apt-get install %s\n' "${missing[*]}" >&2
      exit 2
   fi

   say "installing ${#missing[@]} packages: ${missing[*]}"
   log=$(mktemp)
   if ! apt_install >"$log" 2>&1 </dev/null; then
      say "the installation failed; trying once more"
      sleep 5
      logged "$log" apt_install || die 1 "the packages could not be installed"
   fi
   rm -f -- "$log"
   say "packages installed in $((SECONDS - start)) s"
}

# try_packages PURPOSE PACKAGE...    install what is missing of them, or say why not and go on
#
# Where systemd runs, their services would be started, which nobody has asked for; there they are
# installed on servers that test (CI is set) only.
try_packages() {
   local purpose=$1 missing apt log start=$SECONDS
   shift
   mapfile -t missing < <(missing_packages "$@")
   [ ${#missing[@]} -gt 0 ] || return 0
   if ! command -v apt-get >/dev/null; then
      say "$purpose: not installed, here by Debian's names: ${missing[*]}"
   elif { [ -d /run/systemd/system ] && [ -z "${CI-}" ]; } || ! find_apt; then
      say "$purpose; they need: sudo apt-get install ${missing[*]}"
   else
      say "installing ${#missing[@]} packages: ${missing[*]}"
      log=$(mktemp)
      if apt_install >"$log" 2>&1 </dev/null; then
         say "packages installed in $((SECONDS - start)) s"
      else
         tail -n 5 -- "$log" >&2
         say "$purpose: ${missing[*]} could not be installed"
      fi
      rm -f -- "$log"
   fi
}

# Install what reads exported files into the Python environment, where it can be had; or go on.
try_readers() {
   local folder=$venv/node log
   "$venv/bin/python" -c 'import vtk' 2>/dev/null || timeout 300 "$venv/bin/python" -m pip install --quiet \
      --disable-pip-version-check --no-input vtk==9.7.1 >/dev/null 2>&1 </dev/null ||
      say "files for VTK will not be read by it: vtk could not be installed"
   [ ! -e "$folder/node_modules/gltf-validator" ] || return 0
   command -v node npm >/dev/null || return 0
   log=$(mktemp)
   mkdir -p -- "$folder"
   timeout 120 npm install --silent --prefix "$folder" gltf-validator@2.0.0-dev.3.10 >"$log" 2>&1 </dev/null ||
      say "files of glTF will not be validated: gltf-validator could not be installed"
   rm -f -- "$log"
}

# Install the programs into which examples put our contacts, and what runs notebooks, into the Python
# environment, where they can be had; or go on. Each may be missing by itself.
try_hosts() {
   local name
   for name in scipy==1.17.1 mujoco==4.0.0 exudyn==1.13.6 "nbclient==0.11.0 ipykernel==7.4.0"; do
      # shellcheck disable=SC2086
      "$venv/bin/python" -c "import ${name%%==*}" 2>/dev/null || timeout 300 "$venv/bin/python" -m pip install \
         --quiet --disable-pip-version-check --no-input $name >/dev/null 2>&1 </dev/null ||
         say "examples of hosts will be skipped: ${name%%==*} could not be installed"
   done
}

# ensure_packages [EXTRA_PACKAGE...]    what a build needs and more
# shellcheck disable=SC2120
ensure_packages() { need_packages "${build_packages[@]}" "$@"; }

# The system's Python, whatever python3 comes first on PATH.
system_python() {
   if [ -x /usr/bin/python3 ]; then
      printf '%s\n' /usr/bin/python3
   else
      command -v python3
   fi
}

# Hash of what the environment is made from: the pinned list and the interpreter.
python_stamp() {
   {
      cat -- "$root/requirements.txt"
      readlink -f -- "$(system_python)" || true
   } | sha256sum
}

# One attempt at installing the pinned list into the environment.
pip_install() {
   "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-input \
      --requirement "$root/requirements.txt"
}

make_python() {
   local log start=$SECONDS
   [ "$(cat -- "$venv/.stamp" 2>/dev/null)" != "$(python_stamp)" ] || return 0

   need_packages "${python_packages[@]}"
   say "making the Python environment in .venv"
   rm -rf -- "$venv"
   log=$(mktemp)
   logged "$log" "$(system_python)" -m venv -- "$venv" || die 1 "the Python environment could not be made"
   if ! pip_install >"$log" 2>&1 </dev/null; then
      say "the installation failed; trying once more"
      sleep 5
      logged "$log" pip_install || die 1 "the Python packages could not be installed"
   fi
   rm -f -- "$log"
   python_stamp >"$venv/.stamp"
   say "Python environment made in $((SECONDS - start)) s"
}

make_build() {
   local name=$1 folder=$root/$1 start=$SECONDS quiet=no stamp newest how=()
   shift
   stamp=$(printf '%s\n' "$root" "$@")
   if [ -f "$folder/build.ninja" ] && [ "$(cat -- "$folder/.stamp" 2>/dev/null)" = "$stamp" ]; then
      # The commit is looked up in every build, so there is always a little to do.
      [[ $(ninja -C "$folder" -n "${build_targets[@]}" 2>/dev/null) == *ortran* ]] || quiet=yes
   else
      say "configuring $name"
      if [ -f "$folder/build.ninja" ] && [ ! -e "$folder/.stamp" ]; then
         how=(--reconfigure) # made by hand: keep what else was chosen there
      else
         # Other options, another place, or never completed. The folder stays: it is the lock.
         find "$folder" -mindepth 1 -delete
      fi
      logged "$folder/setup.log" meson setup "${how[@]}" "$@" "$folder" "$root" || return 1
      printf '%s\n' "$stamp" >"$folder/.stamp"
   fi
   [ "$quiet" = yes ] || say "compiling $name"
   logged "$folder/compile.log" ninja -C "$folder" src/libcontensou.a || return 1
   # Meson does not know that the programs depend on the library's module files.
   newest=$(find "$folder/src" -name '*.mod' -printf '%T@ %p\n' | sort -n | tail -n 1)
   find "$folder/drivers" "$folder/tests" -name '*.o' ! -newer "${newest#* }" -delete
   logged "$folder/compile.log" ninja -C "$folder" "${build_targets[@]}" || return 1
   [ "$quiet" = yes ] || say "$name compiled in $((SECONDS - start)) s"
}

# Let only one script at a time do this with a file or folder: only_one LOCK COMMAND...
only_one() {
   local lock=$1
   shift
   (
      flock 9 || true
      "$@" 9>&-
   ) 9<"$lock"
}

# The stamp of the environment is written last, so a half-made one is made again. The lock is on
# requirements.txt, which stays as it is.
ensure_python() { only_one "$root/requirements.txt" make_python; }

# What to compile, all if there is nothing.
build_targets=()

# ensure_build NAME MESON_OPTION...    the folder NAME in the project root
#
# Other folders may be built at the same time.
ensure_build() {
   mkdir -p -- "$root/$1"
   only_one "$root/$1" make_build "$@"
}

# The program that the scripts run.
ensure_release() {
   build_targets=(drivers/contensou)
   ensure_build build --buildtype=release
}
