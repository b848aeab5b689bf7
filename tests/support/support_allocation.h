/* Allocations that fail, for tests of what the library does without memory. A program that uses
 * this has its own malloc() and so on, for the libraries that it loads as well, if the C library
 * allows that: not with sanitizers. */
#ifndef CVOL_TESTS_SUPPORT_ALLOCATION_H
#define CVOL_TESTS_SUPPORT_ALLOCATION_H

#include <stddef.h>

/* How many fail: the n-th allocation alone, or all from the n-th on. */
typedef enum allocation_failure { ALLOCATION_ONE = 1, ALLOCATION_ALL_FROM } allocation_failure;

/* False if allocations cannot be replaced: then the functions below do nothing. */
int allocation_is_replaced(void);

/* The n-th allocation from now on fails, n >= 1. */
void allocation_fail(long n, allocation_failure how);
/* Nothing fails any more. Returns true if nothing failed: there were fewer than n allocations. */
int allocation_stop(void);

/* Lists the allocations from now on that have a call stack that none before them had. */
void allocation_record(void);
/* Ends the list; *numbers, which belongs to this file, holds their numbers from 1. */
size_t allocation_recorded(const long **numbers);

/* The number of pieces of memory that are allocated and not freed. */
long allocation_count(void);

#endif
