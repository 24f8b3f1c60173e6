/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi pod`, a part of the list in options/options.h. */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_POD_H
#define MCVISI_HOST_OPTIONS_OPTIONS_POD_H

#define MCV_POD_OPTIONS(X) \
    X(text, size_column, "size", 0, "NAME", MCV_IN_POD, "size", 0, 0, \
      "the column of the sizes of the defects; a row with the size 0 is a flawless part") \
    X(text, signal_column, "signal", 0, "NAME", MCV_IN_POD, NULL, 0, 0, \
      "the column of the signals, which grow with the size; or give --hit") \
    X(text, hit_column, "hit", 0, "NAME", MCV_IN_POD, NULL, 0, 0, \
      "the column of hits and misses, 1 and 0; or give --signal") \
    X(text, defect_column, "defect", 0, "NAME", MCV_IN_POD, NULL, 0, 0, \
      "the column that identifies the defect of a row; only the first row of each defect counts, " \
      "because two images of one defect are not independent; by default each row is another " \
      "defect") \
    X(text, threshold, "threshold", 0, "Y", MCV_IN_POD, NULL, 0, 0, \
      "the signal from which on a defect is detected") \
    X(text, false_calls, "false-calls", 0, "P", MCV_IN_POD, NULL, 0, 0, \
      "instead of --threshold: the chance that a flawless part is called defective, above 0 and " \
      "below 1; from the signals of rows of size 0, whose noise is assumed to be normal") \
    X(text, lost_below, "lost-below", 0, "Y", MCV_IN_POD, NULL, 0, 0, \
      "signals at or below Y are lost in the noise: their values do not count (censored)") \
    X(text, saturated_above, "saturated-above", 0, "Y", MCV_IN_POD, NULL, 0, 0, \
      "signals at or above Y are saturated: their values do not count (censored)") \
    X(choice, size_scale, "size-scale", 0, "auto|linear|log", MCV_IN_POD, "auto", 0, 0, \
      "the size itself or its logarithm; auto: what fits better") \
    X(choice, signal_scale, "signal-scale", 0, "auto|linear|log", MCV_IN_POD, "auto", 0, 0, \
      "the signal itself or its logarithm; auto: what fits better") \
    X(choice, size_unit, "size-unit", 0, "m|none", MCV_IN_POD, "m", 0, 0, \
      "unit of the sizes: metres, as in tables of `mcvisi sweep`, or plain numbers") \
    X(number, confidence, "confidence", 0, "C", MCV_IN_POD, "0.95", 0.5, 0.9999, \
      "confidence of each bound") \
    X(text, pod_page, "output", 'o', "F.html", MCV_IN_POD, NULL, 0, 0, \
      "also write a page: the answer, the curve with its band, and what the answer covers") \
    X(text, pod_title, "title", 0, "TEXT", MCV_IN_POD, NULL, 0, 0, \
      "the page's heading; by default Probability of detection") \
    X(text, pod_note, "note", 0, "TEXT", MCV_IN_POD, NULL, 0, 0, \
      "a sentence below the page's heading: what was tested")

#endif
