#!/usr/bin/env bash
# Draws what bench_planner --json printed: cost against time for every solver and start, a panel for each number of steps.
# usage: tools/plot_planners.sh BENCH.json PICTURE.png
set -euo pipefail
[ $# -eq 2 ] || { sed -n 3p "$0" | cut -c3- >&2; exit 64; }
data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT
python3 - "$1" "$data" <<'PY'
import json, pathlib, sys
rows = json.load(open(sys.argv[1]))["planner"]
for row in rows:
    file = pathlib.Path(sys.argv[2]) / f"{row['solver']}.{row['start']}.{row['T']}"
    file.write_text(f"{row['ms_median']} {row['ms_90']} {row['cost_ratio_median']}\n")
PY
{
  echo "set terminal pngcairo noenhanced size 1500,560 font 'DejaVu Sans,11'; set output '$2'"
  echo "set multiplot layout 1,3; set logscale xy; set grid; set key at graph 0.98,0.98 right top font ',9'"
  echo "set xlabel 'time of a plan, ms (median; bar to 90 %)'; set ylabel 'cost / best found (median)'; set yrange [0.95:60]; set xrange [1:3000]"
  mapfile -t solvers < <(cd "$data" && printf '%s\n' *.* | cut -d. -f1 | sort -u)
  for steps in 32 64 100; do
    echo "set title 'T = $steps'"
    plots=()
    for i in "${!solvers[@]}"; do
      plots+=("NaN with points pt 5 lc $((i + 1)) title '${solvers[$i]}'")
      for start in rest:6 ik:7 best:9; do
        file=$data/${solvers[$i]}.${start%:*}.$steps
        [ -f "$file" ] && plots+=("'$file' using 1:3:1:2 with xerrorbars pt ${start#*:} ps 1.3 lc $((i + 1)) lw 1.5 notitle")
      done
    done
    for start in rest:6 ik:7 best:9; do plots+=("NaN with points pt ${start#*:} lc 'black' title 'start ${start%:*}'"); done
    (IFS=,; echo "plot ${plots[*]}")
  done
} | gnuplot
