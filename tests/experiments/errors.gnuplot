# SPDX-License-Identifier: MIT
# Error after each sweep, one diagram for each errors-*.tsv in the current folder -> errors.png.
# Run by tests/experiments/zheng_cai.
files = system("ls -v errors-*.tsv")
set terminal pngcairo size 1200,900 font "sans,11"
set output "errors.png"
set datafile separator tab
set key autotitle columnhead
set logscale y
set format y "10^{%T}"
set xrange [0:20]
set yrange [1e-16:0.1]
set xtics 2
set ytics 1e-16, 100
set grid
set xlabel "sweep"
set ylabel "error / bounding box"
set style data linespoints
set multiplot layout ceil(words(files) / 2.0), 2
do for [i = 1:words(files)] {
  file = word(files, i)
  set title file[8:strlen(file) - 4] noenhanced
  plot file using 1:2 lw 2 pt 5 ps 0.7, "" using 1:3 lw 2 pt 7 ps 0.7, "" using 1:4 lw 2 pt 9 ps 0.7
}
unset multiplot
