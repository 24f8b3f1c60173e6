/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Signals. SIGINT, SIGTERM, SIGHUP and SIGXCPU request to finish and save. The second of them ends
 * the program at once, if it comes half a second later or more. SIGUSR1 requests to save and go on.
 * A file above the limit of its size is an error of its write, no signal.
 */
#ifndef MCVISI_HOST_CLI_INTERRUPT_H
#define MCVISI_HOST_CLI_INTERRUPT_H

#include "core/error.h"

#include <signal.h>

/* The signal that requests to end, or 0. */
extern volatile sig_atomic_t mcv_interrupt;

/* To be called first: SIGXFSZ is ignored. When the program crashes, as some drivers do on damaged
 * files of their own, it first tells which folder to delete. */
void mcv_interrupt_prepare(void);

/* Keeps SIGUSR1 until it is taken, whatever handler LLVM in an OpenCL driver installs meanwhile. To
 * be called before there are other threads. */
void mcv_interrupt_keep_saves(void);

/* Whether SIGUSR1 has come since it was last taken. */
bool mcv_interrupt_take_save(void);

/*
 * Installs all handlers. While saving, the second signal
 * does nothing, so that no temporary file remains. To be called again after kernels were compiled:
 * LLVM in OpenCL drivers installs handlers of its own. SIGHUP stays ignored where it was (nohup).
 */
void mcv_interrupt_watch(bool saving);

/* MCV_INTERRUPTED or MCV_TERMINATED after a signal to end, else MCV_OK. */
mcv_result mcv_interrupt_result(void);

/*
 * The exit code: 128 and the number of the signal that ended the work, else that of the result. A
 * device that fails after the signal fails because of it: the compilers that drivers start receive
 * the signal too, and LLVM removes their files. The sentence then says so.
 */
int mcv_interrupt_code(mcv_result result, mcv_error *error);

#endif
