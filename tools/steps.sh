# shellcheck shell=bash
# What tools/setup, tools/test and tools/demo share: headlines, retries, progress with time left. Sourced, never run.

if [[ -t 1 ]]; then bold=$'\e[1m' red=$'\e[31m' plain=$'\e[0m'; else bold='' red='' plain=''; fi

say() { printf '%s\n' "$*"; }
headline() { printf '\n%s%s%s\n' "$bold" "$*" "$plain"; }
complain() { printf '%s%s%s\n' "$red" "$*" "$plain" >&2; }

# 75 -> 1:15
clock() { printf '%d:%02d' $(($1 / 60)) $(($1 % 60)); }

# Compilers that run at once: one a core, and 1.5 GB each, which Eigen's templates need.
job_count() {
  local cores memory_kb
  cores=$(nproc)
  memory_kb=$(awk '/^MemAvailable/ {print $2}' /proc/meminfo)
  local fit=$((memory_kb / 1500000))
  ((fit < 1)) && fit=1
  printf '%s' "${AIRSIDE_JOBS:-$((cores < fit ? cores : fit))}"
}

# retry WHAT COMMAND...: up to four attempts, since a mirror may be busy for a moment.
retry() {
  local what=$1 attempt pause=5
  shift
  for attempt in 1 2 3 4; do
    "$@" && return 0
    ((attempt == 4)) && break
    say "  $what did not succeed; attempt $((attempt + 1)) of 4 in $pause s"
    sleep "$pause"
    pause=$((pause * 3))
  done
  complain "$what failed four times"
  return 1
}

# show_progress LOG: keeps stdin in LOG and shows how far it is. Understands ninja's and tools/tidy's "[3/40]", ctest's
# "3/40 Test" and apt's "Get:3" and "Setting up" (out of $apt_total). A line each 10 s, or one live line on a terminal.
show_progress() {
  local log=$1 begun=$SECONDS shown=-100 every=10 done_count=0 total=0 line live=''
  [[ -t 1 ]] && every=1 live=yes
  : >"$log"
  while IFS= read -r line || [[ -n $line ]]; do
    printf '%s\n' "$line" >>"$log"
    if [[ $line =~ ^\[([0-9]+)/([0-9]+)\] || $line =~ ^[[:space:]]*([0-9]+)/([0-9]+)[[:space:]]Test ]]; then
      done_count=${BASH_REMATCH[1]} total=${BASH_REMATCH[2]}
    elif [[ -n ${apt_total:-} && $line =~ ^(Get:|Setting up) ]]; then
      done_count=$((done_count + 1)) total=$apt_total
    else
      continue
    fi
    local elapsed=$((SECONDS - begun))
    if ((done_count > 0 && elapsed > 0 && SECONDS - shown >= every)); then
      shown=$SECONDS
      local left=$((done_count < total ? elapsed * (total - done_count) / done_count : 0))
      local filled=$((done_count < total ? 24 * done_count / total : 24)) bar
      printf -v bar '%*s' "$filled" ''
      printf '%s  [%-24s] %d of %d, %s gone, about %s left%s' "${live:+$'\r'}" "${bar// /#}" "$done_count" "$total" \
        "$(clock "$elapsed")" "$(clock "$left")" "${live:-$'\n'}" | sed 's/yes$/   /'
    fi
  done
  [[ -n $live && $shown -ge 0 ]] && printf '\n'
  return 0
}
