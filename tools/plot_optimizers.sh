#!/usr/bin/env bash
# Draws what bench_optimizer printed: median evaluations to the target against the dimension, a panel for each function.
# usage: tools/plot_optimizers.sh BENCH.json PICTURE.png
set -euo pipefail
[ $# -eq 2 ] || { sed -n 3p "$0" | cut -c3- >&2; exit 64; }
data=$(mktemp -d)
trap 'rm -rf "$data"' EXIT
python3 - "$1" "$data" <<'PY'
import json, pathlib, sys
for row in json.load(open(sys.argv[1]))["results"]:
    if row["target"] > 1e-8 or row["function"] not in ("sphere", "ellipsoid", "rosenbrock"):
        continue
    if row["optimizer"] not in ("cma", "pagmo cmaes"):
        continue
    low, high = row["quartiles"]
    with open(pathlib.Path(sys.argv[2]) / f"{row['function']}.{row['optimizer'].replace(' ', '_')}", "a") as file:
        file.write(f"{row['dimension']} {row['median_evaluations']} {low} {high}\n")
PY
{
  echo "set terminal pngcairo noenhanced size 1200,420 font 'DejaVu Sans,11'; set output '$2'"
  echo "set multiplot layout 1,3; set logscale xy; set grid; set key right bottom; set xrange [8:50]; set yrange [1000:200000]"
  echo "set xtics (10,20,40); set xlabel 'dimension'; set ylabel 'evaluations to 1e-8 (median, quartiles)'"
  for function in sphere ellipsoid rosenbrock; do
    echo "set title '$function'"
    plots=()
    colour=1
    for optimizer in cma pagmo_cmaes; do
      file=$data/$function.$optimizer
      [ -f "$file" ] && plots+=("'$file' using 1:2:3:4 with yerrorlines pt 7 lw 2 lc $colour title '${optimizer/_/ }'")
      colour=$((colour + 1))
    done
    (IFS=,; echo "plot ${plots[*]}")
  done
} | gnuplot
