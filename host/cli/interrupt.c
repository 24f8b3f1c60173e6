/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/interrupt.h"

#include <signal.h>

static volatile sig_atomic_t received;

static void receive(int signal) { received = signal; }

void mcv_interrupt_watch(bool saving) {
    /* SA_RESETHAND: the handler serves once; the second signal finds the system's own, which ends the program. */
    struct sigaction action = {.sa_handler = receive, .sa_flags = SA_RESTART | (saving ? 0 : (int)SA_RESETHAND)};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

mcv_result mcv_interrupt_received(void) { return received == 0 ? MCV_OK : received == SIGTERM ? MCV_TERMINATED : MCV_INTERRUPTED; }
