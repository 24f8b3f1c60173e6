/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MCVISI_HOST_CLI_TELL_H
#define MCVISI_HOST_CLI_TELL_H

/* Prints "mcvisi: SEVERITY: TEXT" to standard error; severity NULL: an error that ends the
 * program. */
void mcv_tell(const char *severity, const char *text);

#endif
