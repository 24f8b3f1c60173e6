/* SPDX-License-Identifier: Apache-2.0 */
/* Emitters are chosen by the lobe of a glossy surface. */
#define GLOSSY_SURFACES 1
#include "test_reach.c"
