/* SPDX-License-Identifier: Apache-2.0 */
/* The options of long renders and of their parts, a piece of the list in options/options.h. */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_LONG_H
#define MCVISI_HOST_OPTIONS_OPTIONS_LONG_H

#define MCV_LONG_OPTIONS(X) \
    X(text, merged, "output", 'o', "F.exr|F.csv", MCV_IN_MERGE, NULL, 0, 0, \
      "the OpenEXR image, or the table") \
    X(text, checkpoint, "checkpoint", 0, "FILE", MCV_IN_RENDER, NULL, 0, 0, \
      "where the unfinished render is saved, each minute and when it is interrupted, for " \
      "--resume; by default the name of the OpenEXR image with .checkpoint, from the second " \
      "minute " \
      "on; off: nowhere") \
    X(text, part, "film", 0, "FILE", MCV_IN_RENDER, NULL, 0, 0, \
      "with --samples: also write the film, for `mcvisi merge`") \
    X(flag, resume, "resume", 0, NULL, MCV_IN_RENDERS, NULL, 0, 0, \
      "continue a table, or a render from its checkpoint, to the bits that it would have had; " \
      "images that are finished stay; scene and options must be the same") \
    X(text, share, "range", 0, "I/N", MCV_IN_SWEEP, NULL, 0, 0, \
      "render only a part of the sets, the I-th of N from 0 on: those whose number leaves the " \
      "rest I when divided by N; the table is named after it, F.I-of-N.csv; `mcvisi merge` joins " \
      "the tables")

#endif
