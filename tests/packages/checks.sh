# shellcheck shell=bash
# One named check after another, for scripts that end with "N passed, N failed". Sourced, never run; wants $work and $log.

passed=0 failed=0

# check SENTENCE COMMAND...: one test.
check() {
  local sentence=$1
  shift
  # shellcheck disable=SC2154
  printf '\n== %s\n' "$sentence" >>"$log"
  # shellcheck disable=SC2154
  if "$@" >"$work/said" 2>&1; then
    passed=$((passed + 1))
    say "  ok     $sentence"
  else
    failed=$((failed + 1))
    complain "  FAILED $sentence"
    tail -n 12 "$work/said" >&2
  fi
  cat "$work/said" >>"$log"
}
refused() { ! "$@"; }

# need_root SCRIPT WORDS...: goes on as root, in mounts of its own, which vanish with it.
need_root() {
  if ((EUID != 0)); then
    sudo -n true 2>/dev/null && exec sudo -n "$@"
    complain "$1: neither root nor sudo without a password; expected one of them, to install packages"
    exit 1
  fi
  [[ -n ${AIRSIDE_OWN_MOUNTS:-} ]] || AIRSIDE_OWN_MOUNTS=yes exec unshare --mount --propagation private "$@"
}

# Why the throw-away overlay of this machine's own root cannot be made here, in a sentence; nothing where it can.
why_no_overlay() {
  local as=() tried
  if ((EUID != 0)); then
    sudo -n true 2>/dev/null || { echo "this user is not root and sudo asks for a password"; return; }
    as=(sudo -n)
  fi
  # shellcheck disable=SC2016
  tried=$("${as[@]}" unshare --mount --propagation private sh -c 'd=$(mktemp -d) && mount -t tmpfs none "$d" &&
    mkdir "$d/upper" "$d/work" "$d/root" && mount -t overlay overlay -o "lowerdir=/,upperdir=$d/upper,workdir=$d/work" "$d/root"
    code=$?; umount -R "$d" 2>/dev/null; rmdir "$d"; exit "$code"' 2>&1) || echo "${tried%%$'\n'*}"
}

# What lies under $work goes; where a check failed, the folder stays for a look.
clean_work() {
  awk -v work="$work/" 'index($2, work) == 1 {print $2}' /proc/mounts | sort -r | xargs -r umount -l
  if ((failed == 0)); then rm -rf "$work"; else say "kept for a look: ${work#"$source_dir"/}"; fi
}
