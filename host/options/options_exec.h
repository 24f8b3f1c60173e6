/* SPDX-License-Identifier: Apache-2.0 */
/* The options of sets that are judged: by programs, with noise of their own. A part of the list in
 * options/options.h. */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_EXEC_H
#define MCVISI_HOST_OPTIONS_OPTIONS_EXEC_H

#define MCV_EXEC_OPTIONS(X) \
    X(flag, allow_exec, "allow-exec", 0, NULL, MCV_IN_EXPERIMENTS | MCV_IN_POD, NULL, 0, 0, \
      "let a --metric that stands in a file run a program, NAME:=exec(PROGRAM WORDS) or " \
      "NAME:=worker(PROGRAM WORDS); metrics on the command line may") \
    X(count, exposures, "exposures", 0, "K", MCV_IN_EXPERIMENTS, "1", 1, 10000, \
      "exposures of each render that programs look at; the metric is the mean of their answers") \
    X(time, exec_time, "exec-time", 0, "T", MCV_IN_EXPERIMENTS, "60", 0, 1e6, \
      "seconds that a program may take for an answer") \
    X(choice, set_noise, "noise", 0, "common|own", MCV_IN_SWEEP, "common", 0, 0, \
      "random numbers of the sets: common, the same for all, so that differences between sets " \
      "are " \
      "less noisy; own, others for each scene, as `mcvisi pod` needs them") \
    X(number, validate, "validate", 0, "F", MCV_IN_SWEEP, NULL, 0, 0.95, \
      "put this share of the scenes aside: settings of a program, process/NAME, are chosen on " \
      "the " \
      "others, and both rates are told with their intervals; for metrics from 0 to 1")

#endif
