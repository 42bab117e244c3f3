# shellcheck shell=bash
# Fresh Debian systems in folders, for what must work on a new machine. Sourced after setup.sh; needs
# root and debootstrap.
#
#   need_fresh                 can they be had here? Else say why and stop with status 3
#   fresh_system FOLDER        a system of Debian's minimal kind, with the package lists of this one
#   in_fresh FOLDER COMMAND... run a command there
#   remove_fresh FOLDER        remove it

# Systems like the first one are copies of it, made once for each release.
fresh_cache=${CONTENSOU_FRESH:-/var/cache/contensou-fresh}

need_fresh() {
   [ "$(id -u)" -eq 0 ] || die 3 "a fresh Debian needs root"
   [ -e /etc/apt/sources.list.d ] || die 3 "a fresh Debian is made from the package lists of a Debian"
   need_packages debootstrap
}

make_cache() {
   local codename part
   codename=$(. /etc/os-release && echo "$VERSION_CODENAME")
   rm -rf -- "$fresh_cache"
   mkdir -p -- "$fresh_cache"
   debootstrap --variant=minbase --include=ca-certificates "$codename" "$fresh_cache" "$(mirror)" || return 1
   # How this system reaches its packages: lists, settings, the network, certificates.
   for part in /etc/apt/sources.list /etc/apt/sources.list.d /etc/apt/apt.conf.d /etc/pip.conf \
      /etc/resolv.conf /etc/hosts /etc/ssl/certs; do
      # Links there lead to files of this system: they go first.
      rm -rf -- "$fresh_cache$part"
      [ ! -e "$part" ] || cp -rL -- "$part" "$fresh_cache$(dirname -- "$part")/" || return 1
   done
   touch -- "$fresh_cache/.ready"
}

fresh_system() {
   local log
   if [ ! -e "$fresh_cache/.ready" ]; then
      say "making a fresh Debian in $fresh_cache"
      log=$(mktemp)
      logged "$log" make_cache || die 3 "a fresh Debian could not be made"
      rm -f -- "$log"
   fi
   rm -rf --one-file-system -- "$1"
   cp -a -- "$fresh_cache" "$1"
   mount --bind /proc "$1/proc" 2>/dev/null || true
}

in_fresh() {
   local folder=$1 pass
   shift
   mapfile -t pass < <(env | grep -iE '^(PIP_|https?_proxy=|no_proxy=)' || true)
   chroot "$folder" /usr/bin/env -i HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive \
      PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin "${pass[@]}" "$@"
}

remove_fresh() {
   [ -d "$1" ] || return 0
   while mountpoint -q "$1/proc"; do
      umount "$1/proc"
   done
   rm -rf --one-file-system -- "$1"
}
