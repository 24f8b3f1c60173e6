/* SPDX-License-Identifier: Apache-2.0 */
/* The options of verbs that render many sets of parameters, a part of the list MCV_OPTIONS, which
 * explains its columns (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_EXPERIMENT_H
#define MCVISI_HOST_OPTIONS_OPTIONS_EXPERIMENT_H

#define MCV_EXPERIMENT_OPTIONS(X) \
    X(list, vary, "vary", 0, "PATH=VALUES", MCV_IN_SWEEP | MCV_IN_OPTIMIZE, NULL, 0, 0, \
      "a parameter of the scene, a path as for --set, and its values FROM..TO:N, " \
      "FROM..TO:N:log or A,B,C (optimize: FROM..TO, FROM..TO:log or A,B,C), as in --vary " \
      "emitters/back/halfAngle=0.1deg..2deg:8; " \
      "expressions and the table use the last word of the path, halfAngle, as its name; may " \
      "be repeated") \
    X(list, tie, "tie", 0, "PATH=EXPR", MCV_IN_EXPERIMENTS, NULL, 0, 0, \
      "a parameter that follows from others, as in --tie nodes/back/distance=2*distance+10mm; " \
      "may be repeated") \
    X(list, where, "where", 0, "EXPR", MCV_IN_SWEEP | MCV_IN_OPTIMIZE, NULL, 0, 0, \
      "leave out sets for which this is 0 or false, as in --where 'halfAngle<1deg || " \
      "fNumber>8'; may be repeated") \
    X(choice, design, "design", 0, "grid|list|lhs|sobol", MCV_IN_SWEEP, "grid", 0, 0, \
      "which sets: grid, all combinations; list, the first values of all parameters, then the " \
      "second, and so on; lhs, a Latin hypercube; sobol, Sobol' points") \
    X(list, objective, "objective", 0, "NAME=largest|smallest", MCV_IN_OPTIMIZE, NULL, 0, 0, \
      "what is to be reached with a metric; up to three, whose best compromises are then found") \
    X(list, require, "require", 0, "EXPR", MCV_IN_OPTIMIZE, NULL, 0, 0, \
      "a comparison of metrics and parameters that the best set must meet, as in " \
      "'saturated<0.01' or 'sharpness>=20*blur'; up to four") \
    X(list, better, "better", 0, "NAME=D", MCV_IN_OPTIMIZE, NULL, 0, 0, \
      "the least difference of an objective that matters: the search stops when nothing better " \
      "by D is likely to be left; by default 1 % of the range that it has seen first") \
    X(count, evaluations, "evaluations", 0, "N", MCV_IN_OPTIMIZE, "120", 0, 400, \
      "renders at most, those that confirm the result counted") \
    X(list, tolerance, "tolerance", 0, "PATH=DISTRIBUTION", MCV_IN_UNCERTAINTY, NULL, 0, 0, \
      "a parameter of the scene, a path as for --set, and how it is spread about its value in " \
      "the scene: normal(U), U its standard deviation; uniform(A) or triangular(A) within ±A; " \
      "normal(25mm,0.1mm) is about 25 mm; may be repeated") \
    X(list, correlate, "correlate", 0, "A,B=R", MCV_IN_UNCERTAINTY, NULL, 0, 0, \
      "the correlation coefficient R of two tolerances, by the last words of their paths; may be " \
      "repeated") \
    X(count, repetitions, "repeats", 0, "R", MCV_IN_UNCERTAINTY, "4", 0, 100, \
      "first order: how often all its sets are rendered, each time with other random numbers; 0: " \
      "leave the first order out") \
    X(count, trials, "trials", 0, "N", MCV_IN_UNCERTAINTY, "200", 0, 1000000, \
      "Monte Carlo: draws from the tolerances, each rendered with random numbers of its own; 0: " \
      "leave Monte Carlo out") \
    X(flag, indices, "indices", 0, NULL, MCV_IN_UNCERTAINTY, NULL, 0, 0, \
      "also find Sobol' indices, the share of each parameter in the variance; takes as many " \
      "times --trials renders as there are parameters, and 2 more") \
    X(count, points, "points", 0, "N", MCV_IN_SWEEP, NULL, 1, 1000000, \
      "number of sets of --design lhs and sobol") \
    X(count, design_seed, "design-seed", 0, "S", MCV_IN_EXPERIMENTS, "0", 0, UINT32_MAX, \
      "another Latin hypercube, other Sobol' points, other draws from the tolerances") \
    X(list, metric, "metric", 0, "[NAME:=]EXPR", MCV_IN_EXPERIMENTS, NULL, 0, 0, \
      "what to measure: an expression of figures of `mcvisi measure`, NAME.FIGURE of a " \
      "region, edge, line, caliper, circle or arc, or FIGURE of the first one: " \
      "dent.contrast_to_noise, mtf50; may be repeated") \
    X(list, until, "until", 0, "NAME=U", MCV_IN_EXPERIMENTS, NULL, 0, 0, \
      "render until the standard uncertainty of this metric is at most U, and that of every " \
      "other metric with --until at most its own, within --spp and --time; may be repeated") \
    X(text, bound, "bound", 0, "PATH=STEP", MCV_IN_EXPERIMENTS, NULL, 0, 0, \
      "a parameter of the scene and a small step of it, as in nodes/part/shiftZ=0.1mm: the " \
      "figure " \
      "`bound` is the least standard uncertainty [SI] with which one exposure can tell it " \
      "(Cramér-Rao); each set is rendered with and without the step, by the same random numbers") \
    X(choice, in, "in", 0, "image|emd-gradient", MCV_IN_EXPERIMENTS, "image", 0, 0, \
      "measure in the image, or in the Earth Mover's gradient of a light field image") \
    X(text, best, "best", 0, "NAME=largest|smallest", MCV_IN_SWEEP, NULL, 0, 0, \
      "mark the set in which this metric is largest or smallest, and tell which sets are as " \
      "good") \
    X(text, title, "title", 0, "TEXT", MCV_IN_EXPERIMENTS, NULL, 0, 0, \
      "the page's heading; by default the verb and the rig's name") \
    X(text, note, "note", 0, "TEXT", MCV_IN_EXPERIMENTS, NULL, 0, 0, \
      "a sentence below the page's heading: what the experiment is to show") \
    X(text, table, "output", 'o', "F.csv", MCV_IN_EXPERIMENTS, NULL, 0, 0, \
      "the table; by default RIG-VERB.csv or EXPERIMENT-VERB.csv. Beside it are written " \
      "F.json, the experiment, and F.html, the page") \
    X(text, images, "images", 0, "FOLDER", MCV_IN_SWEEP, NULL, 0, 0, \
      "keep the image of each set in this folder, as OpenEXR") \
    X(flag, again, "force", 0, NULL, MCV_IN_EXPERIMENTS | MCV_IN_MERGE, NULL, 0, 0, \
      "begin an existing table again, whose rows are lost; merge: replace it")

#endif
