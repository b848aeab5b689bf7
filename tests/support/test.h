/* The headers that every test needs. A test includes this file first. */
#ifndef CVOL_TESTS_TEST_H
#define CVOL_TESTS_TEST_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* asprintf, mkdtemp, M_PI */
#endif
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#endif
