/* SPDX-License-Identifier: Apache-2.0 */
/* Ctrl-C and SIGTERM: the first asks to finish and save, the second ends the program at once. */
#ifndef MCVISI_HOST_CLI_INTERRUPT_H
#define MCVISI_HOST_CLI_INTERRUPT_H

#include "core/error.h"

#include <signal.h>

/* The signal that has come, or 0. */
extern volatile sig_atomic_t mcv_interrupt;

/* Watches for both signals. While saving, the second one is not served, so that no temporary file
 * is left behind. */
void mcv_interrupt_watch(bool saving);

/* MCV_OK, or MCV_INTERRUPTED or MCV_TERMINATED once a signal has come. */
mcv_result mcv_interrupt_result(void);

#endif
