/* SPDX-License-Identifier: Apache-2.0 */
/* One text out of an OpenCL program and what it includes: each `#include "file"` once (those under
 * an #if as often as they stand, since the #if may be false), with #line so that messages name the
 * file. */
#ifndef MCVISI_HOST_CL_FLATTEN_H
#define MCVISI_HOST_CL_FLATTEN_H

#include "core/error.h"

/*
 * Reads <root>/kernels/<program>.cl and, for mcv_cl_build, the probe; includes are looked for in
 * <root>/kernels and <root>/include. *text is malloc'ed. Lines with `#include <…>` are left out:
 * they belong to the host's side of a header.
 */
mcv_result mcv_flatten(const char *root, const char *program, char **text, mcv_error *error);

#endif
