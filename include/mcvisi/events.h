/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MCVISI_EVENTS_H
#define MCVISI_EVENTS_H

/* What happens at a vertex of a path: X(NAME, "word"). */
#define MCV_EVENTS(X) \
    X(START, "start") \
    X(REFRACT, "refract") \
    X(REFLECT, "reflect") \
    X(PASS, "pass") /* boundary without effect (same index on both sides), or a thin sheet */ \
    X(NON_SPECULAR, \
      "end") /* diffuse, glossy, absorbing or emitting surface: a trace ends there */ \
    X(MISS, "miss")
enum {
#define MCV_X(NAME, word) MCV_EVENT_##NAME,
    MCV_EVENTS(MCV_X)
#undef MCV_X
};

#endif
