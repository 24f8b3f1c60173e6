/* SPDX-License-Identifier: Apache-2.0 */
/* Makes one text of an OpenCL program and its includes. Each `#include "file"` is expanded once;
 * those under an #if are expanded every time, because the #if may be false. #line makes messages
 * name the file. */
#ifndef MCVISI_HOST_CL_FLATTEN_H
#define MCVISI_HOST_CL_FLATTEN_H

#include "core/error.h"

/*
 * Reads <root>/kernels/<program>.cl and, for mcv_cl_build, the probe. Includes are searched in
 * <root>/kernels and <root>/include. *text is malloc'ed. Lines with `#include <…>` are removed:
 * they belong to the host's part of a header.
 */
mcv_result mcv_flatten(const char *root, const char *program, char **text, mcv_error *error);

#endif
