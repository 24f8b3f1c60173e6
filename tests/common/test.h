/* SPDX-License-Identifier: Apache-2.0 */
/*
 * cmocka, with the four headers that it wants to see before its own. Each test includes this,
 * itself or by another header.
 *
 * A test function is `static void test_WHAT_HOLDS(void **state)`. Its assertions print file, line
 * and both operands; where these do not tell the case, use fail_msg with the numbers.
 * MCV_SOURCE_DIR and MCV_BINARY_DIR are the folders of the sources and of the build.
 * MCVISI_TEST_FILTER (filter.c) picks functions of a test by name, with * and ?.
 */
#ifndef MCVISI_TESTS_TEST_H
#define MCVISI_TESTS_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#endif
