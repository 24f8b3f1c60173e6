/* SPDX-License-Identifier: Apache-2.0 */
/* Ctrl-C and SIGTERM: the first signal requests to finish and save, the second ends the program at
 * once. */
#ifndef MCVISI_HOST_CLI_INTERRUPT_H
#define MCVISI_HOST_CLI_INTERRUPT_H

#include "core/error.h"

#include <signal.h>

/* The signal that was received, or 0. */
extern volatile sig_atomic_t mcv_interrupt;

/* Installs the handlers for both signals. While saving, the second signal is blocked, so that no
 * temporary file remains. */
void mcv_interrupt_watch(bool saving);

/* MCV_OK, or MCV_INTERRUPTED or MCV_TERMINATED after a signal. */
mcv_result mcv_interrupt_result(void);

#endif
