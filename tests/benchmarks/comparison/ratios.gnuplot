# SPDX-License-Identifier: MIT
# How many times as long as Limn with one thread the others take, one diagram for each
# ratios-*.tsv of the current folder -> ratios.png. Run by tests/benchmarks/compare.
files = system("wc -l ratios-*.tsv | awk '$1 > 2 && $2 != \"total\" { print $2 }'")
rows = ceil(words(files) / 3.0)
set terminal pngcairo size 1500,(380 * rows) font "sans,10"
set output "ratios.png"
set datafile separator tab
set datafile missing "NaN"
set key autotitle columnhead left top
set logscale xy
set format x "10^{%T}"
set xrange [300:2e6]
set yrange [0.3:*]
set grid
set xlabel "vertices"
set ylabel "time / Limn's"
set style data linespoints
set multiplot layout rows, 3
do for [i = 1:words(files)] {
  file = word(files, i)
  set title file[8:strlen(file) - 4] noenhanced
  columns = int(system("head -n 1 " . file . " | awk -F'\t' '{ print NF }'"))
  plot for [c = 2:columns] file using 1:c lw 2 pt (c + 3) ps 0.8
}
unset multiplot
